// SPDX-License-Identifier: Apache-2.0
// Draco's own decoders allocate memory for the announced size of the data. Here they are checked at the two places
// where the size is known and no memory has been allocated yet: before the connectivity, and before the attributes.
#include "gltf/draco_mesh.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>

#include "gltf/gltf_component.h"
#include "gltf/gltf_json.h"

namespace spheretree::formats {
namespace {

constexpr std::uint64_t kTrianglesPerByte = 64;            // an eighth of a bit for each; real meshes take at least two bits
constexpr std::uint64_t kAlwaysAllowedTriangles = 65'536;  // always allowed
constexpr std::uint64_t kMaxAttributes = 32;
constexpr std::uint64_t kMaxVertexBytes = 256;  // for all attributes

struct Limits {
  std::uint64_t triangles = 0;
  bool exceeded = false;
};

/// Throws before memory is allocated beyond the limits.
template <class Decoder>
class BoundedDecoder : public Decoder {
 public:
  explicit BoundedDecoder(Limits& limits) : limits_(limits) {}

 protected:
  static constexpr bool kIsEdgebreaker = std::is_same_v<Decoder, draco::MeshEdgebreakerDecoder>;

  bool DecodeConnectivity() override {
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t vertices = 0, triangles = 0, symbols = 0, splits = 0;
    std::uint8_t attribute_decoders = 0;
    if constexpr (kIsEdgebreaker) {
      if (!draco::DecodeVarint(&vertices, &ahead) || !draco::DecodeVarint(&triangles, &ahead) || !ahead.Decode(&attribute_decoders) ||
          !draco::DecodeVarint(&symbols, &ahead) || !draco::DecodeVarint(&splits, &ahead))
        return false;
    } else {
      if (!draco::DecodeVarint(&triangles, &ahead) || !draco::DecodeVarint(&vertices, &ahead)) return false;
    }
    const std::uint64_t largest = limits_.triangles;
    limits_.exceeded = triangles > largest || vertices > 3 * largest || splits > largest || attribute_decoders > kMaxAttributes;
    return !limits_.exceeded && Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const auto count = static_cast<std::uint64_t>(this->point_cloud()->num_attributes());
    std::uint64_t vertex_bytes = 0;
    for (int a = 0; a < static_cast<int>(count); ++a)
      vertex_bytes += static_cast<std::uint64_t>(std::max<std::int64_t>(this->point_cloud()->attribute(a)->byte_stride(), 0));
    limits_.exceeded = count > kMaxAttributes || vertex_bytes > kMaxVertexBytes;
    return !limits_.exceeded && Decoder::DecodeAllAttributes();
  }

 private:
  Limits& limits_;
};

std::optional<std::uint64_t> componentOf(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return kInt8;
    case draco::DT_UINT8:
      return kUint8;
    case draco::DT_INT16:
      return kInt16;
    case draco::DT_UINT16:
      return kUint16;
    case draco::DT_UINT32:
      return kUint32;
    case draco::DT_FLOAT32:
      return kFloat32;
    default:
      return std::nullopt;
  }
}

class DracoReader {
 public:
  DracoReader(std::span<const unsigned char> bytes, std::uint64_t max_triangles, const MeshAssembly& assembly, const std::string& where)
      : bytes_(bytes), max_triangles_(max_triangles), assembly_(assembly), where_(where) {}

  DracoMesh read(std::span<const std::uint64_t> attribute_ids) {
    decode();
    DracoMesh result;
    result.vertex_count = mesh_.num_points();
    result.corners.reserve(std::size_t{3} * mesh_.num_faces());
    for (draco::FaceIndex f(0); f < mesh_.num_faces(); ++f)
      for (const draco::PointIndex& corner : mesh_.face(f)) {
        if (corner.value() >= result.vertex_count) refuse("has Draco data that name a vertex that does not exist");
        result.corners.push_back(corner.value());
      }
    if (result.corners.empty()) refuse("has Draco data without a triangle");
    for (const std::uint64_t id : attribute_ids) result.attributes.push_back(attribute(id));
    return result;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { refuseElement(assembly_, where_, what); }

  void decode() {
    const auto start = [&] {
      draco::DecoderBuffer buffer;
      buffer.Init(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
      return buffer;
    };
    draco::DecoderBuffer buffer = start();
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) refuse("has Draco data with a wrong header");
    if (header.version_major != 2 || header.version_minor != 2)
      refuse("has Draco data of version " + std::to_string(header.version_major) + "." + std::to_string(header.version_minor) +
             "; glTF has 2.2");
    if (header.encoder_type != draco::TRIANGULAR_MESH) refuse("has Draco data that are not a mesh");
    Limits limits{.triangles = std::min(max_triangles_, std::max(kAlwaysAllowedTriangles, bytes_.size() * kTrianglesPerByte))};
    buffer = start();
    bool is_ok = false;
    try {
      const draco::DecoderOptions options;
      if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        is_ok = BoundedDecoder<draco::MeshEdgebreakerDecoder>(limits).Decode(options, &buffer, &mesh_).ok();
      else if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        is_ok = BoundedDecoder<draco::MeshSequentialDecoder>(limits).Decode(options, &buffer, &mesh_).ok();
    } catch (const std::exception&) {  // a container was to be resized beyond its limit
      is_ok = false;
    }
    if (limits.exceeded)
      assembly_.refuse(where_ + " has Draco data that announce more than the " + std::to_string(limits.triangles) + " triangles that " +
                       std::to_string(bytes_.size()) + " bytes may hold here, or more attributes than glTF has. Export it without Draco.");
    if (!is_ok) refuse("has Draco data that cannot be unpacked");
  }

  DracoAttribute attribute(std::uint64_t id) const {
    const std::string name = "the attribute with id " + std::to_string(id);
    const draco::PointAttribute* from =
        id <= std::numeric_limits<std::uint32_t>::max() ? mesh_.GetAttributeByUniqueId(static_cast<std::uint32_t>(id)) : nullptr;
    if (!from) refuse("names " + name + ", which its Draco data lack");
    const std::optional<std::uint64_t> component = componentOf(from->data_type());
    const std::size_t components = from->num_components(),
                      size = components * static_cast<std::size_t>(draco::DataTypeLength(from->data_type()));
    if (!component || components < 1 || components > 4) refuse("has Draco data in which " + name + " is of a type that glTF does not have");
    if (from->size() == 0 || from->buffer() == nullptr || from->byte_stride() < static_cast<std::int64_t>(size) || from->byte_offset() < 0)
      refuse("has Draco data in which " + name + " is empty");
    const std::uint64_t vertices = mesh_.num_points();
    DracoAttribute result{.component = *component, .components = components, .is_normalised = from->normalized(), .bytes = {}};
    result.bytes.resize(vertices * size);
    const std::uint64_t stride = static_cast<std::uint64_t>(from->byte_stride()), offset = static_cast<std::uint64_t>(from->byte_offset());
    if (!from->is_mapping_identity() && from->indices_map_size() < vertices) refuse("has Draco data in which " + name + " is too short");
    for (std::uint64_t v = 0; v < vertices; ++v) {
      const std::uint64_t value = from->mapped_index(draco::PointIndex(static_cast<std::uint32_t>(v))).value();
      if (value >= from->size() || offset + value * stride + size > from->buffer()->data_size())
        refuse("has Draco data in which " + name + " has no value for vertex " + std::to_string(v));
      std::memcpy(result.bytes.data() + v * size, from->buffer()->data() + offset + value * stride, size);
    }
    return result;
  }

  std::span<const unsigned char> bytes_;
  std::uint64_t max_triangles_;
  const MeshAssembly& assembly_;
  const std::string& where_;
  draco::Mesh mesh_;
};

}  // namespace

DracoMesh decodeDraco(std::span<const unsigned char> bytes, std::span<const std::uint64_t> attribute_ids, std::uint64_t max_triangles,
                      const MeshAssembly& assembly, const std::string& where) {
  return DracoReader(bytes, max_triangles, assembly, where).read(attribute_ids);
}

}  // namespace spheretree::formats
