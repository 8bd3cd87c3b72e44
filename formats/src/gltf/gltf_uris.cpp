// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_uris.h"

#include <algorithm>
#include <cstddef>
#include <system_error>

#include "gltf/gltf_json.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "text/text_scan.h"

namespace spheretree::formats {

std::vector<unsigned char> GltfUris::open(const std::string& uri, const std::string& where) {
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
      refuseElement(assembly_, where + ".uri", "is a data URI, but not of base64");
    return decodeBase64(std::string_view(uri).substr(comma + 1), where);
  }
  std::string slashed = uri;  // as every viewer takes it: a backslash, from a program on Windows, parts folders
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  const std::filesystem::path path = resolve(percentDecoded(slashed, where), where);
  if (external_bytes_ >= kMaxFileBytes) refuseElement(assembly_, where, "is one of buffers of more than 4 GiB together");
  const std::vector<std::byte> file = readFile(path, kMaxFileBytes - external_bytes_);
  external_bytes_ += file.size();
  const auto* first = reinterpret_cast<const unsigned char*>(file.data());
  return {first, first + file.size()};
}

std::vector<unsigned char> GltfUris::decodeBase64(std::string_view text, const std::string& where) const {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::vector<unsigned char> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int filled = 0;
  for (const char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (value < 0) refuseElement(assembly_, where + ".uri", "has " + inQuotes(std::string_view(&c, 1)) + " in its base64 data");
    bits = (bits << 6 | static_cast<std::uint32_t>(value)) & 0xffffff;
    if ((filled += 6) >= 8) bytes.push_back(static_cast<unsigned char>(bits >> (filled -= 8)));
  }
  return bytes;
}

std::string GltfUris::percentDecoded(std::string_view uri, const std::string& where) const {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string result;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    char c = uri[i];
    if (c == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      c = static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    }
    if (c == '\0') refuseElement(assembly_, where + ".uri", "has a zero character");
    result += c;
  }
  return result;
}

std::filesystem::path GltfUris::resolve(const std::string& uri, const std::string& where) const {
  const auto refuseUri = [&](const std::string& why) {
    assembly_.refuse(where + " lies in " + inQuotes(uri) + ", which " + why +
                     ". Put the buffer into the folder of the glTF file, or export a GLB.");
  };
  if (folder_.empty()) refuseUri("is another file, which is not read here");
  if (uri.find("://") != std::string::npos) refuseUri("is not a file on this machine");
  const std::filesystem::path relative = toPath(uri);
  if (relative.empty() || relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end())
    refuseUri("does not stay within the folder of the glTF file");
  std::error_code error;
  const std::filesystem::path path = std::filesystem::canonical(folder_ / relative, error);
  if (error)
    throw FileError(toUtf8(folder_ / relative) + ": cannot be read: " + error.message() + ". " + assembly_.name() +
                    " needs this buffer: put it next to the file, or export a GLB.");
  const std::filesystem::path base = std::filesystem::canonical(folder_, error);
  if (error || std::mismatch(base.begin(), base.end(), path.begin(), path.end()).first != base.end())
    refuseUri("leads out of the folder of the glTF file through a link");
  if (!std::filesystem::is_regular_file(path, error)) refuseUri("is not a plain file");
  return path;
}

}  // namespace spheretree::formats
