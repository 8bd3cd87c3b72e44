// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/tissue_codec.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "section_bytes.h"

namespace spheretree {
namespace {

struct TissueRecord {
  double young_kpa, poisson, density_kg_m3;
  std::uint32_t nodes, tetrahedra, fixed, vertices;
};
static_assert(sizeof(TissueRecord) == 40);

Bytes tissueSection(const Tissue& tissue) {
  Bytes bytes;
  put(bytes, TissueRecord{.young_kpa = tissue.material.young_kpa,
                          .poisson = tissue.material.poisson,
                          .density_kg_m3 = tissue.material.density_kg_m3,
                          .nodes = static_cast<std::uint32_t>(tissue.nodes.size()),
                          .tetrahedra = static_cast<std::uint32_t>(tissue.tetrahedra.size()),
                          .fixed = static_cast<std::uint32_t>(tissue.fixed.size()),
                          .vertices = static_cast<std::uint32_t>(tissue.surface.size())});
  putArray(bytes, tissue.nodes);
  putArray(bytes, tissue.surface);
  putArray(bytes, tissue.tetrahedra);
  putArray(bytes, tissue.fixed);
  return bytes;
}

LoadStatus readTissue(const Section& section, Tissue& tissue, std::string& fault) {
  if (section.bytes.size() < sizeof(TissueRecord)) return badSize(section, sizeof(TissueRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<TissueRecord>();
  const std::uint64_t size = sizeof record + std::uint64_t{record.nodes} * 24 + std::uint64_t{record.tetrahedra} * 16 +
                             std::uint64_t{record.fixed} * 4 + std::uint64_t{record.vertices} * sizeof(TissueVertex);
  if (section.bytes.size() != size) return badSize(section, size, fault);
  tissue.material = {record.young_kpa, record.poisson, record.density_kg_m3};
  taker.takeArray(tissue.nodes, record.nodes);
  taker.takeArray(tissue.surface, record.vertices);
  taker.takeArray(tissue.tetrahedra, record.tetrahedra);
  taker.takeArray(tissue.fixed, record.fixed);
  return LoadStatus::Ok;
}

// Leaves: counts, then the arrays in their memory layout.

struct LeavesRecord {
  std::uint32_t leaves, cuts, corners, reserved;
};
static_assert(sizeof(LeavesRecord) == 16);

Bytes leavesSection(const Tissue& tissue) {
  const TissueLeaves& leaves = tissue.leaves;
  Bytes bytes;
  put(bytes, LeavesRecord{.leaves = static_cast<std::uint32_t>(leaves.anchors.size()),
                          .cuts = static_cast<std::uint32_t>(leaves.cuts.size()),
                          .corners = static_cast<std::uint32_t>(leaves.corners.size()),
                          .reserved = 0});
  putArray(bytes, leaves.cuts);
  putArray(bytes, leaves.anchors);
  putArray(bytes, leaves.begin);
  putArray(bytes, leaves.corners);
  return bytes;
}

LoadStatus readLeaves(const Section& section, Tissue& tissue, std::string& fault) {
  if (section.bytes.size() < sizeof(LeavesRecord)) return badSize(section, sizeof(LeavesRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<LeavesRecord>();
  const std::uint64_t size = sizeof record + std::uint64_t{record.cuts} * sizeof(TissueCut) +
                             std::uint64_t{record.leaves} * sizeof(LeafAnchor) + (std::uint64_t{record.leaves} + 1) * 4 +
                             std::uint64_t{record.corners} * 4;
  if (section.bytes.size() != size) return badSize(section, size, fault);
  if (record.reserved != 0) return badSection(section, ": reserved bytes are not zero", fault);
  TissueLeaves& leaves = tissue.leaves;
  taker.takeArray(leaves.cuts, record.cuts);
  taker.takeArray(leaves.anchors, record.leaves);
  taker.takeArray(leaves.begin, std::size_t{record.leaves} + 1);
  taker.takeArray(leaves.corners, record.corners);
  return LoadStatus::Ok;
}

// Response: counts, then the arrays in their memory layout; all are empty if there is no response.

struct ResponseRecord {
  std::uint32_t pressed, points;
};
static_assert(sizeof(ResponseRecord) == 8);

Bytes responseSection(const Tissue& tissue) {
  const TissueResponse& response = tissue.response;
  Bytes bytes;
  put(bytes, ResponseRecord{.pressed = static_cast<std::uint32_t>(response.pressed.size()),
                            .points = static_cast<std::uint32_t>(response.points.size())});
  putArray(bytes, response.pressed);
  putArray(bytes, response.points);
  putArray(bytes, response.matrix);
  return bytes;
}

LoadStatus readResponse(const Section& section, Tissue& tissue, std::string& fault) {
  if (section.bytes.size() < sizeof(ResponseRecord)) return badSize(section, sizeof(ResponseRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<ResponseRecord>();
  if (record.pressed > tissue.nodes.size()) return badSection(section, " presses more nodes than there are", fault);
  const std::uint64_t numbers = 9 * std::uint64_t{record.pressed} * record.pressed;
  const std::uint64_t size =
      sizeof record + std::uint64_t{record.pressed} * 4 + std::uint64_t{record.points} * sizeof(PressPoint) + numbers * 4;
  if (section.bytes.size() != size) return badSize(section, size, fault);
  TissueResponse& response = tissue.response;
  taker.takeArray(response.pressed, record.pressed);
  taker.takeArray(response.points, record.points);
  taker.takeArray(response.matrix, numbers);
  return LoadStatus::Ok;
}

// All of these sections or none, in this order, after those of the tree.
struct TissueSection {
  SectionId id;
  Bytes (*write)(const Tissue&);
  LoadStatus (*read)(const Section&, Tissue&, std::string& fault);
};
constexpr std::array<TissueSection, 3> kTissueSections{{
    {{'T', 'I', 'S', 'S'}, tissueSection, readTissue},
    {{'T', 'L', 'E', 'A'}, leavesSection, readLeaves},
    {{'T', 'R', 'E', 'S'}, responseSection, readResponse},
}};

LoadStatus decode(std::span<const std::byte> bytes, SphereTree& tree_out, Tissue& tissue_out, std::string& fault) {
  SphereTree tree;
  if (const LoadStatus status = decodeSphereTree(bytes, tree, &fault); status != LoadStatus::Ok) return status;
  std::vector<Section> sections;
  if (const LoadStatus status = openSections(bytes, sections, fault); status != LoadStatus::Ok) return status;
  Tissue tissue;
  std::size_t found = 0;
  for (const Section& section : sections) {
    const auto known =
        std::find_if(kTissueSections.begin(), kTissueSections.end(), [&](const TissueSection& s) { return s.id == section.id; });
    if (known == kTissueSections.end()) continue;
    if (known != kTissueSections.begin() + static_cast<std::ptrdiff_t>(found))
      return badSection(section, " is out of order", fault, LoadStatus::BadHeader);
    if (const LoadStatus status = known->read(section, tissue, fault); status != LoadStatus::Ok) return status;
    ++found;
  }
  if (found != 0 && found != kTissueSections.size()) {
    fault = describe("section '%.4s' is missing", kTissueSections[found].id.data());
    return LoadStatus::BadHeader;
  }
  if (found != 0) {
    fault = findFault(tissue, tree);
    if (!fault.empty()) return LoadStatus::BadTree;
  }
  tree_out = std::move(tree);
  tissue_out = std::move(tissue);
  return LoadStatus::Ok;
}

}  // namespace

std::vector<std::byte> encodeSoftTree(const SphereTree& tree, const Tissue& tissue) {
  if (const std::string fault = findFault(tissue, tree); !fault.empty()) throw std::invalid_argument("tissue cannot be stored: " + fault);
  const Bytes rigid = encodeSphereTree(tree);
  std::vector<Section> sections;
  std::string fault;
  if (openSections(rigid, sections, fault) != LoadStatus::Ok)
    throw std::logic_error("a tree that was just encoded cannot be read: " + fault);
  SectionWriter file;
  for (const Section& section : sections) file.add(section.id, section.is_optional, Bytes(section.bytes.begin(), section.bytes.end()));
  for (const TissueSection& section : kTissueSections) file.add(section.id, true, section.write(tissue));
  return file.finish();
}

LoadStatus decodeSoftTree(std::span<const std::byte> bytes, SphereTree& tree, Tissue& tissue, std::string* fault) noexcept try {
  std::string ignored;
  return decode(bytes, tree, tissue, fault != nullptr ? *fault : ignored);
} catch (const std::bad_alloc&) {
  return LoadStatus::OutOfMemory;
}

}  // namespace spheretree
