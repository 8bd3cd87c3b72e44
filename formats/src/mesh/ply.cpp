// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "mesh/mesh_assembly.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

enum class Scalar { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };
enum class Encoding { Ascii, Little, Big };

std::optional<Scalar> scalarOf(std::string_view word) {
  static constexpr std::pair<std::string_view, Scalar> kNames[] = {
      {"char", Scalar::Int8},     {"int8", Scalar::Int8},       {"uchar", Scalar::Uint8},    {"uint8", Scalar::Uint8},
      {"short", Scalar::Int16},   {"int16", Scalar::Int16},     {"ushort", Scalar::Uint16},  {"uint16", Scalar::Uint16},
      {"int", Scalar::Int32},     {"int32", Scalar::Int32},     {"uint", Scalar::Uint32},    {"uint32", Scalar::Uint32},
      {"float", Scalar::Float32}, {"float32", Scalar::Float32}, {"double", Scalar::Float64}, {"float64", Scalar::Float64}};
  for (const auto& [name, scalar] : kNames)
    if (name == word) return scalar;
  return std::nullopt;
}

std::size_t sizeOf(Scalar scalar) {
  switch (scalar) {
    case Scalar::Int8:
    case Scalar::Uint8:
      return 1;
    case Scalar::Int16:
    case Scalar::Uint16:
      return 2;
    case Scalar::Int32:
    case Scalar::Uint32:
    case Scalar::Float32:
      return 4;
    case Scalar::Float64:
      break;
  }
  return 8;
}

bool isInteger(Scalar scalar) { return scalar != Scalar::Float32 && scalar != Scalar::Float64; }

struct Property {
  std::string name;
  Scalar type;
  std::optional<Scalar> count_type;  // of a list
};

struct Element {
  std::string name;
  std::uint64_t count;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  PlyReader(std::span<const char> bytes, const std::string& name, double unit_mm) : assembly_(name, unit_mm), bytes_(bytes) {}

  MeshFile read() {
    readHeader();
    const Element *vertex = findOne("vertex"), *face = findOne("face");
    if (!vertex) assembly_.refuse("has no element \"vertex\". Export the mesh again.");
    if (!face) {
      assembly_.refuse(findOne("tristrips")
                           ? "has triangle strips in place of faces. Export the mesh as faces."
                           : "has no element \"face\", only points. A solid needs faces: export the surface as triangles.");
    }
    planVertex(*vertex);
    planFace(*face);
    if (face < vertex) assembly_.refuse("gives its faces before its vertices. Export the mesh again, vertices first.");
    for (const Element& element : elements_) {
      if (&element == vertex)
        readVertices(element);
      else if (&element == face)
        readFaces(element);
      else
        skip(element);
    }
    if (extra_values_)
      assembly_.note(std::to_string(extra_values_) + (extra_values_ == 1 ? " line holds" : " lines hold") +
                     " more values than the header declares; what is beyond was ignored.");
    if (encoding_ != Encoding::Ascii && at_ < bytes_.size())
      assembly_.note(std::to_string(bytes_.size() - at_) + " bytes after the last element were ignored.");
    return assembly_.finish(encoding_ == Encoding::Ascii    ? "PLY (ASCII)"
                            : encoding_ == Encoding::Little ? "PLY (little endian)"
                                                            : "PLY (big endian)");
  }

  /// The columns of vertices and faces.
  std::vector<PlyColumn> columns(const std::string& property) {
    readHeader();
    const std::size_t body = at_, body_line = line_;
    const bool is_colour = property == "colour" || property == "color";
    const std::vector<std::string> names =
        is_colour ? std::vector<std::string>{"red", "green", "blue"} : std::vector<std::string>{property};
    std::vector<PlyColumn> out;
    std::string known;
    for (const char* place : {"vertex", "face"}) {
      const Element* element = findOne(place);
      if (!element) continue;
      for (const Property& p : element->properties)
        if (!p.count_type) known += (known.empty() ? "" : ", ") + p.name;
      if (!hasAll(*element, names)) continue;
      at_ = body, line_ = body_line;
      out.push_back(columnOf(*element, names));
    }
    if (!out.empty()) return out;
    assembly_.refuse("has no property " + inQuotes(property) + " with one number for each vertex or face; it has " +
                     (known.empty() ? "none" : known) + ". Name one of these.");
  }

 private:
  static bool hasAll(const Element& element, const std::vector<std::string>& names) {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == name && !p.count_type; });
    });
  }

  /// Several names: the bytes of one number, the most significant first.
  PlyColumn columnOf(const Element& wanted, const std::vector<std::string>& names) {
    PlyColumn out;
    out.is_of_faces = wanted.name == "face";
    for (const Element& element : elements_) {
      if (&element != &wanted) {
        skip(element);
        continue;
      }
      checkRoom(element);
      for (std::uint64_t row = 0; row < element.count; ++row) {
        beginRow(element, row);
        double value = 0;
        for (const Property& property : element.properties) {
          const auto place = std::find(names.begin(), names.end(), property.name);
          if (place == names.end() || property.count_type) {
            skipProperty(property);
            continue;
          }
          double weight = 1;
          for (auto later = place + 1; later != names.end(); ++later) weight *= 256;
          value += weight * takeNumber(property.type);
        }
        endRow();
        out.values.push_back(value);
      }
      break;
    }
    return out;
  }

  // --- header ---

  std::string_view headerLine() {
    if (at_ >= bytes_.size()) assembly_.refuse("ends within its header. It is cut off: copy or export it again.");
    const std::string_view rest(bytes_.data() + at_, bytes_.size() - at_);
    std::size_t end = rest.find(line_end_[0]);
    if (end == std::string_view::npos) end = rest.size();
    at_ += std::min(end + 1, rest.size());
    // A CR belongs to the line end only if the first line has one: after end_header, the next byte may be data.
    if (line_end_ == "\r\n" && at_ < bytes_.size() && bytes_[at_] == '\n') ++at_;
    ++line_;
    return rest.substr(0, end);
  }

  void readHeader() {
    // The first line determines the line ends of the header.
    if (bytes_.size() < 4 || std::string_view(bytes_.data(), 3) != "ply")
      assembly_.refuse(bytes_.empty() ? "is empty. Export the mesh again." : "does not begin with \"ply\". Export the mesh again.");
    const std::string_view first(bytes_.data(), std::min<std::size_t>(bytes_.size(), 80));
    const std::size_t end = first.find_first_of("\r\n");
    if (end == std::string_view::npos || !trimmed(first.substr(3, end - 3)).empty())
      assembly_.refuse("does not begin with a line \"ply\". Export the mesh again.");
    line_end_ = first[end] == '\n' ? "\n" : end + 1 < first.size() && first[end + 1] == '\n' ? "\r\n" : "\r";
    headerLine();

    bool has_format = false;
    for (;;) {
      std::string_view line = headerLine();
      const std::string_view keyword = takeWord(line);
      if (keyword == "end_header") break;
      if (keyword.empty() || keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "format") {
        const std::string_view encoding = takeWord(line), version = takeWord(line);
        if (encoding == "ascii")
          encoding_ = Encoding::Ascii;
        else if (encoding == "binary_little_endian")
          encoding_ = Encoding::Little;
        else if (encoding == "binary_big_endian")
          encoding_ = Encoding::Big;
        else
          refuseHeader(inQuotes(encoding) + " is no encoding of PLY");
        if (version != "1.0") refuseHeader("version " + inQuotes(version) + " is not read, only 1.0");
        has_format = true;
      } else if (keyword == "element") {
        const std::string_view name = takeWord(line), count_word = takeWord(line);
        std::int64_t count = 0;
        if (!parseInteger(count_word, count) || count < 0) refuseHeader(inQuotes(count_word) + " is not a count");
        elements_.push_back({std::string(name), static_cast<std::uint64_t>(count), {}});
      } else if (keyword == "property") {
        if (elements_.empty()) refuseHeader("a property without an element");
        Property property{};
        std::string_view type = takeWord(line);
        if (type == "list") {
          const std::string_view count_type = takeWord(line);
          property.count_type = scalarOf(count_type);
          if (!property.count_type || !isInteger(*property.count_type)) refuseHeader(inQuotes(count_type) + " cannot count a list");
          type = takeWord(line);
        }
        const std::optional<Scalar> scalar = scalarOf(type);
        if (!scalar) refuseHeader(inQuotes(type) + " is no type of PLY");
        property.type = *scalar;
        property.name = takeWord(line);
        elements_.back().properties.push_back(std::move(property));
      } else {
        refuseHeader(inQuotes(keyword) + " is no keyword of a PLY header");
      }
    }
    if (!has_format) assembly_.refuse("has no format line in its header. Export the mesh again.");
  }

  [[noreturn]] void refuseHeader(const std::string& what) const { assembly_.refuseLine(line_, what + ". Export the mesh again."); }

  const Element* findOne(std::string_view name) const {
    const Element* found = nullptr;
    for (const Element& element : elements_) {
      if (element.name != name) continue;
      if (found) assembly_.refuse("declares the element " + inQuotes(name) + " twice. Export the mesh again.");
      found = &element;
    }
    return found;
  }

  void planVertex(const Element& element) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name(1, "xyz"[axis]);
      const auto found =
          std::find_if(element.properties.begin(), element.properties.end(), [&](const Property& p) { return p.name == name; });
      if (found == element.properties.end() || found->count_type)
        assembly_.refuse("its vertices have no property " + inQuotes(name) + ". Export the mesh again.");
      coordinate_[axis] = static_cast<std::size_t>(found - element.properties.begin());
    }
  }

  void planFace(const Element& element) {
    const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                    [](const Property& p) { return p.name == "vertex_indices" || p.name == "vertex_index"; });
    if (found == element.properties.end() || !found->count_type || !isInteger(found->type))
      assembly_.refuse("its faces have no list \"vertex_indices\" of whole numbers. Export the mesh again.");
    corners_property_ = static_cast<std::size_t>(found - element.properties.begin());
  }

  // --- rows ---

  /// Begins a row of `element`; value() receives its values in order.
  void beginRow(const Element& element, std::uint64_t row) {
    row_ = row;
    element_ = &element;
    if (encoding_ != Encoding::Ascii || element.properties.empty()) return;
    do {
      if (at_ >= bytes_.size()) refuseEnd();
      const std::string_view rest(bytes_.data() + at_, bytes_.size() - at_);
      const std::size_t end = std::min(rest.find(line_end_ == "\r" ? '\r' : '\n'), rest.size());
      text_ = trimmed(rest.substr(0, end));
      at_ += std::min(end + 1, rest.size());
      ++line_;
    } while (text_.empty());
  }
  void endRow() {
    if (encoding_ == Encoding::Ascii && !trimmed(text_).empty()) ++extra_values_;
    text_ = {};
  }

  [[noreturn]] void refuseEnd() const {
    assembly_.refuse("ends within " + element_->name + " " + std::to_string(row_) + " of " + std::to_string(element_->count) +
                     ". It is cut off: copy or export it again.");
  }
  [[noreturn]] void refuseRow(const std::string& what) const {
    const std::string where = element_->name + " " + std::to_string(row_) + " " + what;
    if (encoding_ == Encoding::Ascii) assembly_.refuseLine(line_, where);
    assembly_.refuse(where);
  }

  std::uint64_t takeBits(std::size_t size) {
    if (bytes_.size() - at_ < size) refuseEnd();
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t place = encoding_ == Encoding::Big ? k : size - 1 - k;
      bits = bits << 8 | static_cast<unsigned char>(bytes_[at_ + place]);
    }
    at_ += size;
    return bits;
  }

  std::string_view takeText() {
    const std::string_view word = takeWord(text_);
    if (word.empty())
      refuseRow("has fewer values on its line than the header declares. The file is cut off or damaged: export the mesh again.");
    return word;
  }

  std::int64_t takeInteger(Scalar type) {
    if (encoding_ == Encoding::Ascii) {
      const std::string_view word = takeText();
      std::int64_t value = 0;
      if (!parseInteger(word, value)) refuseRow("has " + inQuotes(word) + " in place of a whole number. Export the mesh again.");
      return value;
    }
    const std::uint64_t bits = takeBits(sizeOf(type));
    switch (type) {
      case Scalar::Int8:
        return static_cast<std::int8_t>(bits);
      case Scalar::Int16:
        return static_cast<std::int16_t>(bits);
      case Scalar::Int32:
        return static_cast<std::int32_t>(bits);
      default:
        return static_cast<std::int64_t>(bits);
    }
  }

  double takeNumber(Scalar type) {
    if (encoding_ == Encoding::Ascii) return assembly_.number(takeText(), line_);
    if (type == Scalar::Float64) return std::bit_cast<double>(takeBits(8));
    if (type == Scalar::Float32) return std::bit_cast<float>(static_cast<std::uint32_t>(takeBits(4)));
    return static_cast<double>(takeInteger(type));
  }

  void skipValue(Scalar type) {
    if (encoding_ == Encoding::Ascii)
      takeText();
    else
      takeBits(sizeOf(type));
  }

  std::uint64_t takeCount(const Property& property) {
    const std::int64_t count = takeInteger(*property.count_type);
    if (count < 0) refuseRow("has a list " + inQuotes(property.name) + " of " + std::to_string(count) + " values. Export the mesh again.");
    return static_cast<std::uint64_t>(count);
  }

  void skipProperty(const Property& property) {
    if (!property.count_type) return skipValue(property.type);
    const std::uint64_t count = takeCount(property);
    for (std::uint64_t k = 0; k < count; ++k) skipValue(property.type);
  }

  /// Checks the smallest possible size of `element`, so that no announced number causes an allocation or a long loop.
  void checkRoom(const Element& element) const {
    std::uint64_t row = 0;
    for (const Property& property : element.properties)
      row += encoding_ == Encoding::Ascii ? 2 : sizeOf(property.count_type ? *property.count_type : property.type);
    if (row > 0 && element.count > (bytes_.size() - at_ + 1) / row)
      assembly_.refuse("announces " + std::to_string(element.count) + " rows of " + inQuotes(element.name) + ", more than its " +
                       std::to_string(bytes_.size()) + " bytes can hold. It is cut off or damaged: copy or export it again.");
  }

  void skip(const Element& element) {
    if (element.properties.empty()) return;
    checkRoom(element);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      beginRow(element, row);
      for (const Property& property : element.properties) skipProperty(property);
      endRow();
    }
  }

  void readVertices(const Element& element) {
    checkRoom(element);
    assembly_.reserve(element.count, 0);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      beginRow(element, row);
      double p[3] = {};
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& property = element.properties[k];
        const auto axis = static_cast<std::size_t>(std::find(coordinate_.begin(), coordinate_.end(), k) - coordinate_.begin());
        if (axis < 3)
          p[axis] = takeNumber(property.type);
        else
          skipProperty(property);
      }
      endRow();
      assembly_.addVertex(p[0], p[1], p[2], encoding_ == Encoding::Ascii ? line_ : 0);
    }
  }

  void readFaces(const Element& element) {
    checkRoom(element);
    std::vector<std::uint32_t> corners;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      beginRow(element, row);
      corners.clear();
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& property = element.properties[k];
        if (k != corners_property_) {
          skipProperty(property);
          continue;
        }
        const std::uint64_t count = takeCount(property);
        for (std::uint64_t corner = 0; corner < count; ++corner) {
          const std::int64_t index = takeInteger(property.type);
          if (index < 0 || index >= assembly_.vertexCount())
            refuseRow("names vertex " + std::to_string(index) + ", but there are " + std::to_string(assembly_.vertexCount()) +
                      " vertices, counted from 0. Export the mesh again.");
          corners.push_back(static_cast<std::uint32_t>(index));
        }
      }
      endRow();
      assembly_.addPolygon(corners);
    }
  }

  MeshAssembly assembly_;
  std::span<const char> bytes_;
  std::size_t at_ = 0, line_ = 0;
  std::string_view line_end_ = "\n";
  Encoding encoding_ = Encoding::Ascii;
  std::vector<Element> elements_;
  std::array<std::size_t, 3> coordinate_{};  // indices of x, y, z among the properties of a vertex
  std::size_t corners_property_ = 0;
  const Element* element_ = nullptr;  // current element
  std::uint64_t row_ = 0, extra_values_ = 0;
  std::string_view text_;  // rest of the current row
};

}  // namespace

MeshFile readPly(std::span<const char> bytes, const std::string& name, double unit_mm) {
  return PlyReader(asText(bytes, name), name, unit_mm).read();
}

std::vector<PlyColumn> readPlyColumns(std::span<const char> bytes, const std::string& name, const std::string& property) {
  return PlyReader(asText(bytes, name), name, 1).columns(property);
}

}  // namespace spheretree::formats
