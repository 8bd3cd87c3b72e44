// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <regex>
#include <string_view>
#include <vector>

namespace spheretree::tool {
namespace {

std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// Places of the dots, in the order of the points.
std::vector<std::pair<double, double>> dotsOf(const std::string& svg) {
  std::vector<std::pair<double, double>> dots;
  const std::regex dot("<circle class=\"c[op]\" cx=\"([^\"]*)\" cy=\"([^\"]*)\"");
  for (std::sregex_iterator at(svg.begin(), svg.end(), dot), end; at != end; ++at)
    dots.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  return dots;
}

TEST(Chart, ParetoFrontIsWhatNoOtherPointBeats) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    std::vector<ChartPoint> points(1 + random() % 12);
    for (ChartPoint& p : points) p.x = static_cast<double>(1 + random() % 6), p.y = static_cast<double>(1 + random() % 6);
    const std::vector<bool> front = paretoFront(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool beaten = false;
      for (std::size_t j = 0; j < points.size(); ++j) {
        const ChartPoint &p = points[i], &q = points[j];
        const bool equal = q.x == p.x && q.y == p.y;
        beaten |= (q.x <= p.x && q.y <= p.y && !equal) || (equal && j < i);
      }
      EXPECT_EQ(front[i], !beaten) << "round " << round << ", point " << i;
    }
  }
}

TEST(Chart, NumbersAreShortAndTrue) {
  EXPECT_EQ(shortNumber(0), "0");
  EXPECT_EQ(shortNumber(0.012345), "0.0123");
  EXPECT_EQ(shortNumber(12.35), "12.3");
  EXPECT_EQ(shortNumber(1234.5), "1234");
  EXPECT_EQ(shortNumber(-2.5), "-2.5");
  EXPECT_EQ(shortNumber(1), "1");
  EXPECT_EQ(shortNumber(4.1e-6), "4.1e-06");
  for (double value = 1e-9; value < 1e9; value *= 1.7) EXPECT_NEAR(std::stod(shortNumber(value)) / value, 1, 0.05) << value;
}

TEST(Chart, DotsStandWhereTheirLogarithmsAre) {
  ScatterChart chart{"t", "x", "y", {}, {}};
  for (const auto& [x, y] :
       {std::pair{1.0, 1.0}, std::pair{10.0, 100.0}, std::pair{100.0, 10.0}, std::pair{0.0, 5.0}, std::pair{5.0, -1.0}})
    chart.points.push_back({x, y, std::string("s").append(std::to_string(chart.points.size())), "", 1, false});
  const std::string svg = scatterSvg(chart);
  const auto dots = dotsOf(svg);
  ASSERT_EQ(dots.size(), 3u) << "what is not above 0 has no place on a logarithmic axis";
  EXPECT_NEAR(dots[1].first - dots[0].first, (dots[2].first - dots[0].first) / 2, 0.11);
  EXPECT_NEAR(dots[0].second - dots[2].second, (dots[0].second - dots[1].second) / 2, 0.11);
  EXPECT_LT(dots[1].second, dots[0].second) << "more is higher up";
  for (const char* name : {">s0<", ">s1<", ">s2<"}) EXPECT_EQ(countOf(svg, name), 1u) << name;
  EXPECT_EQ(countOf(svg, "class=\"co\""), 1u) << "only the first is on the front";
}

TEST(Chart, ADotFarAboveAllOthersLeavesThemTheAxis) {
  ScatterChart chart{"t", "x", "y", {}, {}};
  for (int i = 0; i < 8; ++i) chart.points.push_back({1.0 + i, 1.7 - 0.1 * i, std::string("s").append(std::to_string(i)), "", 1, false});
  const auto heightOf = [](const std::vector<std::pair<double, double>>& dots) { return dots.front().second - dots.back().second; };
  const double alone = heightOf(dotsOf(scatterSvg(chart)));
  chart.points.push_back({0.1, 60, "far", "far: 60", 1, false});
  const std::string svg = scatterSvg(chart);
  const auto dots = dotsOf(svg);
  ASSERT_EQ(dots.size(), 8u) << "the ninth is an arrow";
  EXPECT_GT(heightOf(dots) / alone, 0.85);
  EXPECT_EQ(countOf(svg, "z\"><title>far: 60</title></path>"), 1u);
  EXPECT_EQ(countOf(svg, ">far at 60<"), 1u) << "its figure is said, since the axis cannot";
  chart.points.back().y = 4;
  EXPECT_EQ(dotsOf(scatterSvg(chart)).size(), 9u) << "near enough to be shown";
}

TEST(Chart, NamesDoNotCoverEachOther) {
  ScatterChart chart{"t", "x", "y", {}, {}};
  for (int i = 0; i < 9; ++i) chart.points.push_back({1 + 0.01 * i, 2 - 0.01 * i, "builder" + std::to_string(i), "", 1, false});
  chart.points.push_back({100, 200, "far", "", 1, false});  // compresses the others
  const std::string svg = scatterSvg(chart);
  std::vector<std::pair<double, double>> at;
  const std::regex name("<text class=\"cn[^\"]*\" x=\"([^\"]*)\" y=\"([^\"]*)\"[^>]*>builder");
  for (std::sregex_iterator i(svg.begin(), svg.end(), name), end; i != end; ++i) at.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
  ASSERT_EQ(at.size(), 9u);
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_TRUE(std::abs(at[i].first - at[j].first) > 40 || std::abs(at[i].second - at[j].second) > 8) << i << " and " << j;
}

/// The path of the first trace. Not by std::regex, which recurses for every character of such a long match.
std::string tracePathOf(const std::string& svg) {
  const std::string_view head = "<path class=\"t0\" d=\"";
  const std::size_t at = svg.find(head);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + head.size();
  return svg.substr(begin, svg.find('"', begin) - begin);
}

TEST(Chart, ATraceKeepsEveryPeak) {
  TraceChart chart{"t", "s", "N", {}, {{"force", {}}}, false, {}};
  for (int i = 0; i < 100000; ++i) {
    chart.x.push_back(static_cast<float>(i) * 0.001f);
    chart.traces[0].y.push_back(i == 54321 ? 9.0f : 1.0f);
  }
  const std::string svg = traceSvg(chart);
  // Drawn from near the top of the frame (34, and a twentieth of the range below it), at the value 9, down to the value
  // 1.
  EXPECT_NE(tracePathOf(svg).find(" 40V"), std::string::npos) << tracePathOf(svg).substr(0, 200);
  EXPECT_LT(svg.size(), 60000u) << "as many pieces as pixels, however many values";
}

TEST(Chart, AGapInATraceStaysAGap) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  TraceChart chart{"t", "s", "N", {}, {{"force", {}}}, false, {}};
  for (int i = 0; i < 5000; ++i) {
    chart.x.push_back(static_cast<float>(i));
    chart.traces[0].y.push_back(i > 2000 && i < 3000 ? nan : static_cast<float>(i % 7));
  }
  EXPECT_EQ(countOf(tracePathOf(traceSvg(chart)), "M"), 2u);
}

// The name of the y axis is 13 pixels from the left edge, and its letters are 11 pixels high.
TEST(Chart, LabelsOfTicksEndBeforeTheNameOfTheAxis) {
  const std::regex tick("<text class=\"ck\" x=\"([^\"]*)\" y=\"[^\"]*\" text-anchor=\"end\">([^<]*)<");
  const auto check = [&](const std::string& svg) {
    int ticks = 0;
    for (std::sregex_iterator at(svg.begin(), svg.end(), tick), end; at != end; ++at, ++ticks)
      EXPECT_GT(std::stod((*at)[1]) - 6.5 * static_cast<double>((*at)[2].length()), 17) << (*at)[2];
    EXPECT_GE(ticks, 3);
  };
  ScatterChart dots{"t", "x", "y", {}, {}};
  for (const double y : {0.00012, 0.00018, 0.00025}) dots.points.push_back({y, y, "", "", 1, false});
  check(scatterSvg(dots));
  for (const TraceSize size : {TraceSize::Broad, TraceSize::Narrow})
    check(traceSvg({"t", "s", "N", {0, 1, 2}, {{"force", {0.00012f, 0.00018f, 0.00025f}}}, false, {}}, size));
}

TEST(Chart, ANarrowTraceHasItsTitleInLinesThatFitAndAllOfTheCurve) {
  const std::string title = "Energy taken from the hand; below 0 the renderer has given energy";
  TraceChart chart{title, "Time [s]", "Energy [mJ]", {}, {{"energy", {}}}, false, {}};
  for (int i = 0; i < 5000; ++i) chart.x.push_back(static_cast<float>(i) / 1000), chart.traces[0].y.push_back(static_cast<float>(i % 11));
  const std::string narrow = traceSvg(chart, TraceSize::Narrow);
  EXPECT_NE(narrow.find("width=\"400\""), std::string::npos);
  const std::regex line("<text class=\"ct\" x=\"([^\"]*)\"[^>]*>([^<]*)<");
  std::string words;
  for (std::sregex_iterator at(narrow.begin(), narrow.end(), line), end; at != end; ++at) {
    EXPECT_LT(std::stod((*at)[1]) + 7.6 * static_cast<double>((*at)[2].length()), 400) << (*at)[2];
    words += (words.empty() ? "" : " ") + (*at)[2].str();
  }
  EXPECT_EQ(words, title);
  EXPECT_GE(countOf(narrow, "text-anchor=\"middle\""), 3u + 2) << "three ticks on the x axis, and the names of both axes";
  const std::string path = tracePathOf(narrow);
  EXPECT_EQ(countOf(path, "M"), 1u);
  EXPECT_GT(countOf(path, "L"), 200u) << "a point for each column of pixels";
  EXPECT_EQ(traceCharts(chart), traceSvg(chart) + narrow);
}

TEST(Chart, AnEmptyChartSaysSo) {
  EXPECT_NE(scatterSvg({"empty", "x", "y", {}, {}}).find("nothing to show"), std::string::npos);
  EXPECT_NE(traceSvg({"empty", "x", "y", {}, {}, false, {}}).find("nothing to show"), std::string::npos);
}

TEST(Chart, NamesFromOutsideAreEscaped) {
  EXPECT_EQ(escaped("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
  const std::string svg = scatterSvg({"<script>", "x", "y", {{1, 1, "<b>", "<i>", 1, false}}, {}});
  for (const char* tag : {"<script", "<b>", "<i>"}) EXPECT_EQ(svg.find(tag), std::string::npos) << tag;
}

// Programs for papers (Inkscape, rsvg-convert, LaTeX) know no variables of CSS, and draw them black.
TEST(Chart, AFileHasPlainColours) {
  const std::string file = svgFile("Heading", std::vector<std::string>{});
  EXPECT_EQ(countOf(file, "--"), 0u);
  EXPECT_EQ(countOf(file, "@media"), 0u);
  EXPECT_EQ(countOf(file, ".cb{fill:#fff}"), 1u);
  EXPECT_EQ(countOf(file, ".n3{fill:#7a4fb3}"), 1u);
}

}  // namespace
}  // namespace spheretree::tool
