// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree_codec.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "describe.h"
#include "section_bytes.h"
#include "section_file.h"

namespace spheretree {
namespace {

// One byte codes the children of an inner node: the low 4 bits are their number minus one, the high 4 bits the number
// of those that have children.
struct Children {
  std::uint8_t count, inner;
};

std::byte codeOf(unsigned children, unsigned inner) { return static_cast<std::byte>((children - 1) | (inner << 4)); }

/// False if there are more than 8 children, or more inner children than children.
bool readCode(std::byte code, Children& children) {
  const auto bits = static_cast<std::uint8_t>(code);
  children = {static_cast<std::uint8_t>((bits & 0xf) + 1), static_cast<std::uint8_t>(bits >> 4)};
  return children.count <= kMaxBranching && children.inner <= children.count;
}

LoadStatus badCode(const Section& section, std::size_t node, std::string& fault) {
  return badSection(section, describe(": the number of children of inner node %zu is out of range", node).c_str(), fault,
                    LoadStatus::BadTopology);
}

// Topology: a code for each inner node, breadth first.

void writeTopology(const SphereTree& tree, Bytes& bytes) {
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (tree.isLeaf(i)) continue;
    unsigned inner = 0;
    for (std::uint32_t c = 0; c < tree.child_count[i]; ++c) inner += tree.child_count[tree.first_child[i] + c] > 0;
    put(bytes, codeOf(tree.child_count[i], inner));
  }
}

LoadStatus readTopology(const Section& section, SphereTree& tree, std::string& fault) {
  const auto noTree = [&](const char* what) { return badSection(section, what, fault, LoadStatus::BadTopology); };
  const std::size_t inner = section.bytes.size();
  if (inner >= kMaxNodes) return noTree(": there are more inner nodes than a tree can have");
  std::vector<std::uint8_t>& counts = tree.child_count;
  counts.assign(1, 0);
  std::vector<std::uint8_t> is_inner(1, inner > 0);
  std::size_t used = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (is_inner[i] == 0) continue;
    if (used == inner) return noTree(": there are fewer inner nodes than the children make");
    Children children{};
    if (!readCode(section.bytes[used], children)) return badCode(section, used, fault);
    ++used;
    counts[i] = children.count;
    counts.insert(counts.end(), children.count, 0);
    is_inner.insert(is_inner.end(), children.inner, 1);
    is_inner.resize(counts.size(), 0);
    if (counts.size() > kMaxNodes) return noTree(": the children make more nodes than a tree can have");
  }
  if (used != inner) return noTree(": there are more inner nodes than the children make");
  return LoadStatus::Ok;
}

// Cover spheres of all nodes, then bounding spheres of the inner ones, each in the order of the nodes.

void writeCover(const SphereTree& tree, Bytes& bytes) { putArray(bytes, tree.cover); }

LoadStatus readCover(const Section& section, SphereTree& tree, std::string& fault) {
  const std::size_t nodes = tree.child_count.size();
  if (section.bytes.size() != nodes * sizeof(Sphere)) return badSize(section, nodes * sizeof(Sphere), fault);
  Taker(section.bytes).takeArray(tree.cover, nodes);
  if (linkNodes(tree)) return LoadStatus::Ok;
  return badSection(section, ": the nodes have more than 6 levels", fault, LoadStatus::BadTopology);
}

void writeBound(const SphereTree& tree, Bytes& bytes) { putArray(bytes, tree.bound); }

LoadStatus readBound(const Section& section, SphereTree& tree, std::string& fault) {
  const auto leaves = static_cast<std::size_t>(std::count(tree.child_count.begin(), tree.child_count.end(), 0));
  const std::size_t inner = tree.child_count.size() - leaves;
  if (section.bytes.size() != inner * sizeof(Sphere)) return badSize(section, inner * sizeof(Sphere), fault);
  Taker(section.bytes).takeArray(tree.bound, inner);
  return LoadStatus::Ok;
}

// Levels: a record for each, in its memory layout.

static_assert(sizeof(LevelStatistics) == 16);

void writeLevels(const SphereTree& tree, Bytes& bytes) { putArray(bytes, tree.statistics); }

LoadStatus readLevels(const Section& section, SphereTree& tree, std::string& fault) {
  const auto levels = static_cast<std::size_t>(tree.levelCount());
  if (section.bytes.size() != levels * sizeof(LevelStatistics)) return badSize(section, levels * sizeof(LevelStatistics), fault);
  Taker(section.bytes).takeArray(tree.statistics, levels);
  return LoadStatus::Ok;
}

// Provenance, and the frame. Every field is naturally aligned, so there is no padding.

struct ProvenanceRecord {
  std::array<double, 3> origin_mm;
  double unit_mm, diagonal_mm, volume_mm3, area_mm2, tolerance_mm;
  std::uint64_t triangle_count, seed;
  Hash128 mesh_hash, settings_hash;
  std::array<char, 16> builder, quality;
  std::array<char, 32> generator;
  float work_overhang_mm;
  std::uint8_t branching;
  std::array<std::uint8_t, 3> reserved;
};
static_assert(sizeof(ProvenanceRecord) == 184 && offsetof(ProvenanceRecord, mesh_hash) == 80 &&
              offsetof(ProvenanceRecord, builder) == 112 && offsetof(ProvenanceRecord, work_overhang_mm) == 176);

template <std::size_t N>
std::array<char, N> fixedText(const std::string& text) {
  std::array<char, N> field{};
  std::copy(text.begin(), text.end(), field.begin());
  return field;
}

template <std::size_t N>
bool readText(const std::array<char, N>& field, std::string& text) {
  const auto end = std::find(field.begin(), field.end(), '\0');
  if (end == field.end() || std::any_of(end, field.end(), [](char c) { return c != 0; })) return false;
  text.assign(field.begin(), end);
  return true;
}

void writeProvenance(const SphereTree& tree, Bytes& bytes) {
  const Provenance& p = tree.provenance;
  put(bytes, ProvenanceRecord{.origin_mm = tree.origin_mm,
                              .unit_mm = p.unit_mm,
                              .diagonal_mm = p.diagonal_mm,
                              .volume_mm3 = p.volume_mm3,
                              .area_mm2 = p.area_mm2,
                              .tolerance_mm = p.tolerance_mm,
                              .triangle_count = p.triangle_count,
                              .seed = p.seed,
                              .mesh_hash = p.mesh_hash,
                              .settings_hash = p.settings_hash,
                              .builder = fixedText<16>(p.builder),
                              .quality = fixedText<16>(p.quality),
                              .generator = fixedText<32>(p.generator),
                              .work_overhang_mm = p.work_overhang_mm,
                              .branching = tree.branching,
                              .reserved = {}});
}

LoadStatus readProvenance(const Section& section, SphereTree& tree, std::string& fault) {
  if (section.bytes.size() != sizeof(ProvenanceRecord)) return badSize(section, sizeof(ProvenanceRecord), fault);
  const auto record = Taker(section.bytes).take<ProvenanceRecord>();
  tree.origin_mm = record.origin_mm;
  tree.branching = record.branching;
  Provenance& p = tree.provenance;
  p.unit_mm = record.unit_mm, p.diagonal_mm = record.diagonal_mm, p.volume_mm3 = record.volume_mm3, p.area_mm2 = record.area_mm2;
  p.tolerance_mm = record.tolerance_mm, p.work_overhang_mm = record.work_overhang_mm;
  p.triangle_count = record.triangle_count, p.seed = record.seed;
  p.mesh_hash = record.mesh_hash, p.settings_hash = record.settings_hash;
  if (!readText(record.builder, p.builder)) return badSection(section, ": the builder's name is not closed by zeros", fault);
  if (!readText(record.quality, p.quality)) return badSection(section, ": the quality's name is not closed by zeros", fault);
  if (!readText(record.generator, p.generator)) return badSection(section, ": the generator's name is not closed by zeros", fault);
  if (record.reserved != decltype(record.reserved){}) return badSection(section, ": reserved bytes are not zero", fault);
  return LoadStatus::Ok;
}

// Search trees: spheres and codes of the inner nodes.

void putCodes(Bytes& bytes, const SearchTree& search) {
  for (std::size_t i = 0; i < search.inner.size(); ++i)
    put(bytes, codeOf(unsigned{search.inner_children[i]} + search.item_children[i], search.inner_children[i]));
}

LoadStatus readCodes(const Section& section, std::span<const std::byte> codes, SearchTree& search, std::string& fault) {
  for (std::size_t i = 0; i < codes.size(); ++i) {
    Children children{};
    if (!readCode(codes[i], children)) return badCode(section, i, fault);
    search.inner_children.push_back(children.inner);
    search.item_children.push_back(static_cast<std::uint8_t>(children.count - children.inner));
  }
  return LoadStatus::Ok;
}

struct SearchRecord {
  std::uint32_t inner, items;
  std::array<std::uint32_t, 2> reserved;
};
static_assert(sizeof(SearchRecord) == 16);

void writeSearch(const SphereTree& tree, Bytes& bytes) {
  const SearchTree& search = tree.search;
  put(bytes, SearchRecord{static_cast<std::uint32_t>(search.inner.size()), static_cast<std::uint32_t>(search.item.size()), {}});
  putArray(bytes, search.inner);
  putArray(bytes, search.item);
  putCodes(bytes, search);
}

LoadStatus readSearch(const Section& section, SphereTree& tree, std::string& fault) {
  if (section.bytes.size() < sizeof(SearchRecord)) return badSize(section, sizeof(SearchRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<SearchRecord>();
  const std::uint64_t size = sizeof record + std::uint64_t{record.inner} * (sizeof(Sphere) + 1) + std::uint64_t{record.items} * 2;
  if (section.bytes.size() != size) return badSize(section, size, fault);
  if (record.inner == 0) return badSection(section, ": the search tree has no root", fault);
  if (record.reserved != decltype(record.reserved){}) return badSection(section, ": reserved bytes are not zero", fault);
  taker.takeArray(tree.search.inner, record.inner);
  taker.takeArray(tree.search.item, record.items);
  return readCodes(section, taker.rest(), tree.search, fault);
}

// Skin: numbers and counts, then the arrays in their memory layout, except the vertices.

struct SkinRecord {
  std::array<float, 3> low;
  float step, offset_step, tolerance, mesh_distance, crease_angle;
  std::uint32_t inner, triangles, vertices, edges;
};
static_assert(sizeof(SkinRecord) == 48);

struct VertexRecord {
  std::array<std::uint32_t, 2> position;  // 64 bits, the lower half first: three coordinates of 21 bits, and a zero bit
  PackedNormal normal;
};
static_assert(sizeof(VertexRecord) == 12);

VertexRecord recordOf(const SkinVertex& v) {
  const std::uint64_t bits = v.position[0] | std::uint64_t{v.position[1]} << 21 | std::uint64_t{v.position[2]} << 42;
  return {{static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)}, v.normal};
}

// If the bit that should be zero is set, z is too large for findFault().
SkinVertex vertexOf(const VertexRecord& r) {
  const std::uint64_t bits = r.position[0] | std::uint64_t{r.position[1]} << 32;
  const auto lowest = [](std::uint64_t x) { return static_cast<std::uint32_t>(x) & kMaxSkinCoordinate; };
  return {{lowest(bits), lowest(bits >> 21), static_cast<std::uint32_t>(bits >> 42)}, r.normal};
}

void writeSkin(const SphereTree& tree, Bytes& bytes) {
  const Skin& skin = tree.skin;
  put(bytes, SkinRecord{.low = skin.low,
                        .step = skin.step,
                        .offset_step = skin.offset_step,
                        .tolerance = skin.tolerance,
                        .mesh_distance = skin.mesh_distance,
                        .crease_angle = skin.crease_angle,
                        .inner = static_cast<std::uint32_t>(skin.search.inner.size()),
                        .triangles = static_cast<std::uint32_t>(skin.triangles.size()),
                        .vertices = static_cast<std::uint32_t>(skin.vertices.size()),
                        .edges = static_cast<std::uint32_t>(skin.edges.size())});
  putArray(bytes, skin.search.inner);
  putArray(bytes, skin.triangles);
  for (const SkinVertex& v : skin.vertices) put(bytes, recordOf(v));
  putArray(bytes, skin.edges);
  putCodes(bytes, skin.search);
}

LoadStatus readSkin(const Section& section, SphereTree& tree, std::string& fault) {
  if (section.bytes.size() < sizeof(SkinRecord)) return badSize(section, sizeof(SkinRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<SkinRecord>();
  const std::uint64_t size = sizeof record + std::uint64_t{record.inner} * (sizeof(Sphere) + 1) +
                             std::uint64_t{record.triangles} * sizeof(SkinTriangle) +
                             std::uint64_t{record.vertices} * sizeof(VertexRecord) + std::uint64_t{record.edges} * sizeof(SkinEdge);
  if (section.bytes.size() != size) return badSize(section, size, fault);
  if (record.triangles == 0) return badSection(section, ": the skin has no triangles", fault);
  Skin& skin = tree.skin;
  skin.low = record.low, skin.step = record.step, skin.offset_step = record.offset_step;
  skin.tolerance = record.tolerance, skin.mesh_distance = record.mesh_distance, skin.crease_angle = record.crease_angle;
  taker.takeArray(skin.search.inner, record.inner);
  taker.takeArray(skin.triangles, record.triangles);
  skin.vertices = std::vector<SkinVertex>(record.vertices);
  for (SkinVertex& v : skin.vertices) v = vertexOf(taker.take<VertexRecord>());
  taker.takeArray(skin.edges, record.edges);
  return readCodes(section, taker.rest(), skin.search, fault);
}

// Hulls: numbers and counts, then the arrays in their memory layout.

struct HullRecord {
  float overhang_bound;
  std::uint32_t hulls, balls, parts, inner, items;
  std::array<std::uint32_t, 2> reserved;
};
static_assert(sizeof(HullRecord) == 32 && sizeof(HullPart) == 6);

void writeHulls(const SphereTree& tree, Bytes& bytes) {
  const Hulls& hulls = tree.hulls;
  put(bytes, HullRecord{.overhang_bound = hulls.overhang_bound,
                        .hulls = hulls.count,
                        .balls = static_cast<std::uint32_t>(hulls.balls.size()),
                        .parts = static_cast<std::uint32_t>(hulls.parts.size()),
                        .inner = static_cast<std::uint32_t>(hulls.search.inner.size()),
                        .items = static_cast<std::uint32_t>(hulls.search.item.size()),
                        .reserved = {}});
  putArray(bytes, hulls.balls);
  putArray(bytes, hulls.search.inner);
  putArray(bytes, hulls.parts);
  putArray(bytes, hulls.search.item);
  putCodes(bytes, hulls.search);
}

LoadStatus readHulls(const Section& section, SphereTree& tree, std::string& fault) {
  if (section.bytes.size() < sizeof(HullRecord)) return badSize(section, sizeof(HullRecord), fault);
  Taker taker(section.bytes);
  const auto record = taker.take<HullRecord>();
  const std::uint64_t size = sizeof record + std::uint64_t{record.balls} * sizeof(Sphere) +
                             std::uint64_t{record.inner} * (sizeof(Sphere) + 1) + std::uint64_t{record.parts} * sizeof(HullPart) +
                             std::uint64_t{record.items} * 2;
  if (section.bytes.size() != size) return badSize(section, size, fault);
  if (record.parts == 0) return badSection(section, ": the hulls have no parts", fault);
  if (record.reserved != decltype(record.reserved){}) return badSection(section, ": reserved bytes are not zero", fault);
  Hulls& hulls = tree.hulls;
  hulls.overhang_bound = record.overhang_bound, hulls.count = record.hulls;
  taker.takeArray(hulls.balls, record.balls);
  taker.takeArray(hulls.search.inner, record.inner);
  taker.takeArray(hulls.parts, record.parts);
  taker.takeArray(hulls.search.item, record.items);
  return readCodes(section, taker.rest(), hulls.search, fault);
}

// The sections that this program knows, in the order of the file. A new kind of section needs one new row in each of
// two tables. A program that only reads, such as the shared library of the runtime, contains no encoder.

bool always(const SphereTree&) { return true; }
bool hasSearch(const SphereTree& tree) { return !tree.search.empty(); }
bool hasSkin(const SphereTree& tree) { return !tree.skin.empty(); }
bool hasHulls(const SphereTree& tree) { return !tree.hulls.empty(); }

struct SectionDecoder {
  SectionId id;
  bool is_optional;
  LoadStatus (*read)(const Section&, SphereTree&, std::string& fault);  // may use the results of earlier sections
};
constexpr std::array<SectionDecoder, 8> kDecoders{{
    {{'T', 'O', 'P', 'O'}, false, readTopology},
    {{'C', 'O', 'V', 'R'}, false, readCover},
    {{'B', 'N', 'D', 'S'}, false, readBound},
    {{'L', 'E', 'V', 'L'}, false, readLevels},
    {{'P', 'R', 'O', 'V'}, false, readProvenance},
    {{'S', 'R', 'C', 'H'}, true, readSearch},
    {{'S', 'K', 'I', 'N'}, true, readSkin},
    {{'H', 'U', 'L', 'L'}, true, readHulls},
}};

struct SectionEncoder {
  bool (*is_present)(const SphereTree&);
  void (*write)(const SphereTree&, Bytes&);
};
constexpr std::array<SectionEncoder, kDecoders.size()> kEncoders{{
    {always, writeTopology},
    {always, writeCover},
    {always, writeBound},
    {always, writeLevels},
    {always, writeProvenance},
    {hasSearch, writeSearch},
    {hasSkin, writeSkin},
    {hasHulls, writeHulls},
}};

LoadStatus decode(std::span<const std::byte> bytes, SphereTree& out, std::string& fault) {
  std::vector<Section> sections;
  if (const LoadStatus status = openSections(bytes, sections, fault); status != LoadStatus::Ok) return status;
  SphereTree tree;
  const SectionDecoder* next = kDecoders.data();  // the first section that may follow
  const SectionDecoder* const end = next + kDecoders.size();
  const auto isMissing = [&](const SectionDecoder* until) {
    next = std::find_if(next, until, [](const SectionDecoder& c) { return !c.is_optional; });
    if (next != until) fault = describe("section '%.4s' is missing", next->id.data());
    return next != until;
  };
  for (const Section& section : sections) {
    const SectionDecoder* const known = std::find_if(next, end, [&](const SectionDecoder& c) { return c.id == section.id; });
    if (known == end) {
      if (std::any_of(kDecoders.data(), next, [&](const SectionDecoder& c) { return c.id == section.id; }))
        return badSection(section, " is out of order", fault, LoadStatus::BadHeader);
      if (section.is_optional) continue;
      return badSection(section, " is required, and not known", fault, LoadStatus::UnknownSection);
    }
    if (known->is_optional != section.is_optional)
      return badSection(section, " has a wrong flag: required or optional", fault, LoadStatus::BadHeader);
    if (isMissing(known)) return LoadStatus::BadHeader;
    if (const LoadStatus status = known->read(section, tree, fault); status != LoadStatus::Ok) return status;
    next = known + 1;
  }
  if (isMissing(end)) return LoadStatus::BadHeader;
  fault = findFault(tree);
  if (!fault.empty()) return LoadStatus::BadTree;
  out = std::move(tree);
  return LoadStatus::Ok;
}

}  // namespace

std::string_view explain(LoadStatus status) {
  switch (status) {
    case LoadStatus::Ok:
      return "the file is sound";
    case LoadStatus::BadMagic:
      return "this is not a sphere-tree file; name a .stree file, or convert to one";
    case LoadStatus::UnsupportedVersion:
      return "the file is of a format version that this program does not know; use a newer program or build the tree again";
    case LoadStatus::Truncated:
      return "the file ends too early; copy it again";
    case LoadStatus::TrailingBytes:
      return "the file is too long; copy it again";
    case LoadStatus::BadChecksum:
      return "the file is damaged; copy it again or build the tree again";
    case LoadStatus::BadHeader:
      return "the header contradicts itself; build the tree again";
    case LoadStatus::UnknownSection:
      return "the file holds data that this program must know and does not; use a newer program or build the tree again";
    case LoadStatus::BadSection:
      return "a part of the file contradicts the others; build the tree again";
    case LoadStatus::BadTopology:
      return "the nodes do not make a tree; build the tree again";
    case LoadStatus::BadTree:
      return "the tree breaks a rule that its users rely on; build the tree again";
    case LoadStatus::OutOfMemory:
      return "there is not enough memory; close other programs";
  }
  return "unknown status";
}

std::vector<std::byte> encodeSphereTree(const SphereTree& tree) {
  if (const std::string fault = findFault(tree); !fault.empty()) throw std::invalid_argument("sphere-tree cannot be stored: " + fault);
  SectionWriter file;
  for (std::size_t i = 0; i < kEncoders.size(); ++i) {
    if (!kEncoders[i].is_present(tree)) continue;
    Bytes bytes;
    kEncoders[i].write(tree, bytes);
    file.add(kDecoders[i].id, kDecoders[i].is_optional, std::move(bytes));
  }
  return file.finish();
}

LoadStatus decodeSphereTree(std::span<const std::byte> bytes, SphereTree& tree, std::string* fault) noexcept try {
  std::string ignored;
  return decode(bytes, tree, fault != nullptr ? *fault : ignored);
} catch (const std::bad_alloc&) {
  return LoadStatus::OutOfMemory;
}

}  // namespace spheretree
