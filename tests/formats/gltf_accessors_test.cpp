// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_accessors.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <tuple>
#include <vector>

#include "spheretree/formats/errors.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

/// A model of one buffer; its views and accessors are added by the tests.
struct AccessorRig {
  std::vector<unsigned char> bytes;
  GltfModel model;
  MeshAssembly assembly{"a.glb", 1000};

  explicit AccessorRig(std::vector<unsigned char> content) : bytes(std::move(content)) { model.buffers = {bytes}; }
  std::string refusal(std::size_t accessor = 0) const {
    return test::refusalOf<FormatError>([&] { (void)numbers(accessor); });
  }
  Numbers numbers(std::size_t accessor = 0) const {
    WorkBudget work(100, assembly);
    return GltfAccessors(model, assembly, work).numbers(accessor);
  }
};

std::vector<unsigned char> countedBytes(std::size_t count) {
  std::vector<unsigned char> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<unsigned char>(i);
  return bytes;
}

template <class T>
std::vector<unsigned char> bytesOf(const std::vector<T>& values) {
  std::vector<unsigned char> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// Section 3.6.2.2: a byte c is c / 255, or max(c / 127, -1) with a sign; the same with 65535 and 32767.
TEST(GltfAccessors, NumbersAreThoseOfTheSpecification) {
  const auto number = [](std::uint64_t component, const std::vector<unsigned char>& bytes, bool normalised) {
    return Elements{bytes.data(), 4, 1, component}.numberAt(0, 0, normalised);
  };
  for (int bits = 0; bits < 0x10000; ++bits) {
    const auto low = static_cast<unsigned char>(bits), high = static_cast<unsigned char>(bits >> 8);
    const std::vector<unsigned char> bytes{low, high, 0xaa, 0xbb};
    const int with_sign = bits < 0x8000 ? bits : bits - 0x10000, small = bits & 0xff,
              small_with_sign = small < 0x80 ? small : small - 0x100;
    ASSERT_EQ(number(kUint16, bytes, false), bits);
    ASSERT_EQ(number(kUint16, bytes, true), bits / 65535.0);
    ASSERT_EQ(number(kInt16, bytes, false), with_sign);
    ASSERT_EQ(number(kInt16, bytes, true), with_sign == -32768 ? -1 : with_sign / 32767.0);
    ASSERT_EQ(number(kUint8, bytes, false), small);
    ASSERT_EQ(number(kUint8, bytes, true), small / 255.0);
    ASSERT_EQ(number(kInt8, bytes, false), small_with_sign);
    ASSERT_EQ(number(kInt8, bytes, true), small_with_sign == -128 ? -1 : small_with_sign / 127.0);
  }
  EXPECT_EQ(number(kFloat32, bytesOf(std::vector<float>{-1.25f}), false), -1.25);
  const std::vector<unsigned char> bytes{1, 2, 3, 4};
  EXPECT_EQ((Elements{bytes.data(), 4, 1, kUint32}.unsignedAt(0)), 0x04030201u);
  EXPECT_EQ((Elements{bytes.data(), 1, 1, kUint8}.unsignedAt(1, 2)), 4u) << "element 1, component 2";
}

// Against the plain condition, in which nothing overflows for these small numbers.
TEST(GltfAccessors, OpensExactlyWhatLiesWithinTheViewAndTheBuffer) {
  int opened = 0, refused = 0;
  for (const std::uint64_t stride : {0u, 4u, 7u})
    for (std::uint64_t view_offset = 0; view_offset <= 24; view_offset += 3)
      for (std::uint64_t length = 0; length <= 24; ++length)
        for (std::uint64_t offset = 0; offset <= 12; offset += 2)
          for (std::uint64_t count = 1; count <= 5; ++count) {
            AccessorRig rig(countedBytes(24));
            rig.model.views = {{0, view_offset, length, stride}};
            rig.model.accessors = {{0, offset, count, kUint16, 2, false, {}}};
            const std::uint64_t step = stride ? stride : 4;
            const bool fits = view_offset + length <= 24 && offset + (count - 1) * step + 4 <= length;
            EXPECT_EQ(rig.refusal().empty(), fits) << view_offset << ' ' << length << ' ' << stride << ' ' << offset << ' ' << count;
            (fits ? opened : refused)++;
            if (!fits) continue;
            const std::uint64_t at = view_offset + offset + (count - 1) * step + 2;  // of the last number
            EXPECT_EQ(rig.numbers().at(count - 1, 1), static_cast<double>(at + 256 * (at + 1)));
          }
  EXPECT_GT(opened, 500);
  EXPECT_GT(refused, 500);
}

TEST(GltfAccessors, NoSumOrProductOverflows) {
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  struct Case {
    GltfModel::View view;
    std::uint64_t offset, count;
  };
  for (const auto& [view, offset, count] : std::vector<Case>{{{0, kHuge, 24, 0}, 0, 1},
                                                             {{0, 0, kHuge, 0}, 0, 1},
                                                             {{0, 8, kHuge - 7, 0}, 0, 1},
                                                             {{0, 0, 24, 0}, kHuge, 1},
                                                             {{0, 0, 24, 0}, kHuge - 3, 2},
                                                             {{0, 0, 24, 0}, 0, kHuge},
                                                             {{0, 0, 24, 0}, 0, kHuge / 4 + 2},
                                                             {{0, 0, 24, kHuge}, 0, 2},
                                                             {{0, 0, 24, std::uint64_t{1} << 63}, 0, 3}}) {
    AccessorRig rig(countedBytes(24));
    rig.model.views = {view};
    rig.model.accessors = {{0, offset, count, kFloat32, 1, false, {}}};
    EXPECT_TRUE(test::has(rig.refusal(), "reaches beyond the 24 bytes of")) << rig.refusal();
  }
}

TEST(GltfAccessors, SparseElementsReplaceTheOthers) {
  const std::vector<std::uint16_t> where{1, 4};
  AccessorRig rig(bytesOf(std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 100, 101, 102, 103, 104, 105, 0}));
  std::memcpy(rig.bytes.data() + 84, where.data(), 4);
  rig.model.views = {{0, 0, 60, 0}, {0, 84, 4, 0}, {0, 60, 24, 0}};
  GltfModel::Accessor accessor{0, 0, 5, kFloat32, 3, false, GltfModel::Sparse{2, 1, 2, 0, 0, kUint16}};
  for (const bool has_view : {true, false}) {
    if (!has_view) accessor.view.reset();
    rig.model.accessors = {accessor};
    const Numbers numbers = rig.numbers();
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double dense = has_view ? static_cast<double>(3 * i + axis) : 0, sparse = static_cast<double>((i == 1 ? 100 : 103) + axis);
        EXPECT_EQ(numbers.at(i, axis), i == 1 || i == 4 ? sparse : dense) << i << ' ' << axis;
        EXPECT_EQ(numbers.vectorAt(i)[static_cast<Eigen::Index>(axis)], numbers.at(i, axis));
      }
  }
  for (const auto& [first, second, message] : std::vector<std::tuple<int, int, std::string>>{
           {4, 4, "element 1 is 4"}, {4, 1, "element 1 is 1"}, {1, 5, "element 1 is 5; they must rise and stay below 5"}}) {
    const std::vector<std::uint16_t> wrong{static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(second)};
    std::memcpy(rig.bytes.data() + 84, wrong.data(), 4);
    EXPECT_TRUE(test::has(rig.refusal(), "a.glb: accessors[0].sparse.indices " + message)) << rig.refusal();
  }
  rig.model.accessors[0].sparse.reset();
  EXPECT_TRUE(test::has(rig.refusal(), "accessors[0] has no data without extensions")) << rig.refusal();
}

TEST(GltfAccessors, IndicesArePackedAndVerticesMayBeApart) {
  AccessorRig rig(countedBytes(24));
  rig.model.views = {{0, 0, 24, 8}};
  rig.model.accessors = {{0, 1, 3, kUint16, 1, false, {}}};
  EXPECT_EQ(rig.numbers().unsignedAt(2, 0), 17u + 256 * 18);
  WorkBudget work(0, rig.assembly);
  const GltfAccessors accessors(rig.model, rig.assembly, work);
  const auto refusal = [&] { return test::refusalOf<FormatError>([&] { (void)accessors.indices(0); }); };
  EXPECT_TRUE(test::has(refusal(), "bufferViews[0] has a byteStride, which only vertex attributes may have")) << refusal();
  rig.model.views[0].stride = 0;
  EXPECT_EQ(accessors.indices(0).unsignedAt(2), 5u + 256 * 6);
  rig.model.views[0].stride = 4;
  rig.model.accessors[0].components = 3;
  EXPECT_TRUE(test::has(rig.refusal(), "has a byteStride of 4, less than the 6 of an element")) << rig.refusal();
}

TEST(WorkBudget, SpendsItsLimitAndNoMore) {
  const MeshAssembly assembly("a.glb", 1000);
  WorkBudget work(10, assembly);
  work.spend(4);
  EXPECT_TRUE(test::has(test::refusalOf<FormatError>([&] { work.spend(7); }), "a.glb: its nodes repeat meshes to more than 10 triangles"));
  work.spend(6);
  EXPECT_THROW(work.spend(1), FormatError);
  EXPECT_THROW(work.spend(~std::uint64_t{0}), FormatError);
}

}  // namespace
}  // namespace spheretree::formats
