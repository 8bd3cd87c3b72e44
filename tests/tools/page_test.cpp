// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/page.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>

#include "page/embedded.h"
#include "page/model.h"
#include "support/shapes.h"

namespace spheretree::tool {
namespace {

std::string fromBase64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    if ((count += 6) >= 8) out += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return out;
}

std::string inflated(const std::string& text) {
  const std::string bytes = fromBase64(text);
  std::string out(8 << 20, '\0');
  uLongf size = static_cast<uLongf>(out.size());
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                       static_cast<uLong>(bytes.size())),
            Z_OK);
  out.resize(size);
  return out;
}

/// The same decoding as in page.js.
struct Unpacked {
  Json root;
  std::string arrays;
  explicit Unpacked(const PageData& data) {
    const std::string all = inflated(data.packed());
    std::uint32_t length = 0;
    std::memcpy(&length, all.data(), 4);
    root = Json::parse(all.substr(4, length));
    arrays = all.substr(4 + length);
    EXPECT_EQ(length % 4, 0u) << "typed arrays want their alignment";
  }
  template <class T>
  std::vector<T> array(const Json& reference) const {
    std::vector<T> out(reference.at("count").get<std::size_t>());
    const std::size_t at = reference.at("at").get<std::size_t>();
    EXPECT_EQ(at % sizeof(T), 0u);
    EXPECT_LE(at + out.size() * sizeof(T), arrays.size());
    std::memcpy(out.data(), arrays.data() + at, out.size() * sizeof(T));
    return out;
  }
};

std::vector<std::uint32_t> summed(const auto& deltas) {
  std::vector<std::uint32_t> out;
  std::uint32_t last = 0;
  for (const std::uint32_t delta : deltas) out.push_back(last += delta >> 1 ^ (0u - (delta & 1u)));
  return out;
}

TEST(Page, PackedArraysAreRestored) {
  for (const std::size_t size : {0u, 1u, 2u, 3u, 4u, 1000u}) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(i * i);
    EXPECT_EQ(inflated(deflatedBase64(bytes)), bytes) << size;
  }
  PageData data;
  const std::vector<std::uint8_t> small{1, 2, 255};
  const std::vector<float> real{1.5f, -2e9f};
  data.root["small"] = data.add(std::span<const std::uint8_t>(small));
  data.root["real"] = data.add(std::span<const float>(real));
  data.root["name"] = "m\u00fc";
  const Unpacked out(data);
  EXPECT_EQ(out.array<std::uint8_t>(out.root["small"]), small);
  EXPECT_EQ(out.array<float>(out.root["real"]), real);
  EXPECT_EQ(out.root["name"], "m\u00fc");
}

TEST(Page, AMeshComesOutWithinAQuantum) {
  const TriangleMesh mesh = test::sphereMesh(5, 3);
  PageData data;
  data.root = packMesh(data, mesh, builder::surfaceWithSheets(mesh, {}), 100000);
  const Unpacked out(data);
  const auto deltas = out.array<std::uint16_t>(out.root["positions"]);
  const auto indices = summed(out.array<std::uint32_t>(out.root["indices"]));
  const std::size_t count = deltas.size() / 3;
  ASSERT_EQ(count, mesh.positions.size());
  ASSERT_EQ(indices.size(), 3 * mesh.triangles.size());
  const double step = out.root["step"].get<double>();
  EXPECT_LT(step, 10.0 / 30000);
  std::vector<std::vector<std::uint32_t>> axis;
  for (std::size_t k = 0; k < 3; ++k)
    axis.push_back(summed(std::vector<std::uint16_t>(deltas.begin() + static_cast<std::ptrdiff_t>(k * count),
                                                     deltas.begin() + static_cast<std::ptrdiff_t>((k + 1) * count))));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t corner = 0; corner < 3; ++corner)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_NEAR(out.root["low"][k].get<double>() + step * axis[k][indices[3 * t + corner]],
                    mesh.corner(t, static_cast<int>(corner))[static_cast<Eigen::Index>(k)], step);
}

TEST(Page, AThinnedMeshStaysOnItsSurface) {
  const TriangleMesh mesh = test::torusMesh(3, 1, 80, 40);
  const builder::SurfaceWithSheets surface = builder::surfaceWithSheets(mesh, {});
  PageData data;
  data.root = packMesh(data, mesh, surface, 600);
  const Unpacked out(data);
  EXPECT_EQ(out.root["triangles"], mesh.triangles.size()) << "the figure is of the whole mesh";
  const auto deltas = out.array<std::uint16_t>(out.root["positions"]);
  const std::size_t count = deltas.size() / 3;
  EXPECT_LE(out.array<std::uint32_t>(out.root["indices"]).size(), 3u * 600);
  std::vector<std::vector<std::uint32_t>> axis;
  for (std::size_t k = 0; k < 3; ++k)
    axis.push_back(summed(std::vector<std::uint16_t>(deltas.begin() + static_cast<std::ptrdiff_t>(k * count),
                                                     deltas.begin() + static_cast<std::ptrdiff_t>((k + 1) * count))));
  const double step = out.root["step"].get<double>();
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3d p;
    for (std::size_t k = 0; k < 3; ++k) p[static_cast<Eigen::Index>(k)] = out.root["low"][k].get<double>() + step * axis[k][i];
    EXPECT_LT(surface.field.distance(p), 2 * step);
  }
}

TEST(Page, FiguresAreAlignedAtThePointAndWordsAreSetLeft) {
  const std::string html = HtmlTable{
      "caption",
      {"Name", "Size", "State", "Share"},
      {{"a", "13", "built", "0.5 \u2713"},
       {"b", "<span class=\"bad\">0.046</span>", "", "2 \u2713"},
       {"c", "1.2e-05", "built, repaired", "\u2013"},
       {"d", "failed"}}}.html();
  const auto pad = [](const std::string& digits) { return "<i class=\"pad\" aria-hidden=\"true\">" + digits + "</i>"; };
  for (const std::string& cell :
       {"<td>13" + pad(".000") + "</td>", std::string("<td><span class=\"bad\">0.046</span></td>"), std::string("<td>1.2e-05</td>"),
        "<td>2" + pad(".0") + " \u2713</td>", std::string("<td>0.5 \u2713</td>"), std::string("<td>\u2013</td>"),
        std::string("<th scope=\"col\" class=\"text\">State</th>"), std::string("<td class=\"text\">built, repaired</td>"),
        std::string("<td class=\"rest\" colspan=\"3\">failed</td>")})
    EXPECT_NE(html.find(cell), std::string::npos) << cell << "\n" << html;
}

TEST(Page, HoldsItsPartsAndForbidsRequests) {
  Page page("Teeth & <gums>", "<p>verdict</p>");
  page.addSection("one", "First <part>", "<p>body</p>");
  const std::string plain = page.html({});
  EXPECT_NE(plain.find("<title>Teeth &amp; &lt;gums&gt;</title>"), std::string::npos);
  EXPECT_NE(plain.find("default-src 'none'"), std::string::npos);
  EXPECT_NE(plain.find("<a href=\"#one\">First &lt;part&gt;</a>"), std::string::npos);
  EXPECT_LT(plain.size(), 40000u) << "without a view there is no three.js";
  const std::string full = page.html(std::array{embedded::viewScript()});
  EXPECT_GT(full.size(), 200000u);
  for (const char* link : {"src=\"http", "href=\"http", "@import", "url(http"}) EXPECT_EQ(full.find(link), std::string::npos) << link;
}

TEST(Page, EmbeddedFilesAreWhole) {
  EXPECT_EQ(embedded::pageStyle().substr(0, 2), "/*");
  EXPECT_TRUE(embedded::pageScript().ends_with("})();\n"));
  EXPECT_NE(embedded::three().find("REVISION"), std::string_view::npos);
  EXPECT_GT(embedded::three().size(), 500000u);
}

}  // namespace
}  // namespace spheretree::tool
