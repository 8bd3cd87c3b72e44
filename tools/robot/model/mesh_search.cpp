// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/mesh_search.h"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::robot {
namespace {

namespace fs = std::filesystem;

bool isFile(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(path, none);
}

fs::path whole(const fs::path& path) {
  const fs::path plain = fs::absolute(path).lexically_normal();
  return plain.has_filename() ? plain : plain.parent_path();  // without a slash at its end
}

/// The name in the package.xml of a folder, or "".
std::string declaredName(const fs::path& folder) {
  if (!isFile(folder / "package.xml")) return "";
  tinyxml2::XMLDocument document;
  if (document.LoadFile((folder / "package.xml").c_str()) != tinyxml2::XML_SUCCESS) return "";
  const tinyxml2::XMLElement* root = document.RootElement();
  const tinyxml2::XMLElement* name = root ? root->FirstChildElement("name") : nullptr;
  const std::string text = name && name->GetText() ? name->GetText() : "";
  const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// The folders of an environment variable, separated by colons, each with `below`.
void addFolders(const char* variable, const char* below, std::vector<fs::path>& folders) {
  const char* list = std::getenv(variable);
  for (std::string left = list ? list : ""; !left.empty();) {
    const std::size_t end = left.find(':');
    if (end > 0) folders.push_back(whole(fs::path(left.substr(0, end)) / below));
    left = end == std::string::npos ? "" : left.substr(end + 1);
  }
}

/// "%20" and the like as the characters that they stand for.
std::string withoutEscapes(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned byte = 0;
    const char* digits = text.data() + i + 1;
    if (text[i] == '%' && i + 2 < text.size() && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
      out += static_cast<char>(byte);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

/// What comes after the beginning, without the host of a file://.
std::string pathOf(const std::string& name) {
  if (!name.starts_with("file:")) return name;
  const std::string rest = name.substr(name.starts_with("file://") ? 7 : 5);
  return rest.starts_with("localhost/") ? rest.substr(9) : rest;
}

}  // namespace

PackagePaths packagePaths(const std::vector<std::string>& words) {
  PackagePaths out;
  std::error_code none;
  for (const std::string& word : words) {
    const std::size_t at = word.find('=');
    if (fs::is_directory(word, none)) {
      out.folders.push_back(whole(word));
    } else if (at != std::string::npos && at > 0 && fs::is_directory(word.substr(at + 1), none)) {
      out.named[word.substr(0, at)] = whole(word.substr(at + 1));
    } else {
      throw formats::FileError("--package " + word + ": there is no folder " + (at == std::string::npos ? word : word.substr(at + 1)) +
                               ". Give FOLDER or NAME=FOLDER.");
    }
  }
  return out;
}

MeshSearch::MeshSearch(const fs::path& urdf, const PackagePaths& packages) : folder_(whole(urdf).parent_path()), packages_(packages) {
  searched_ = packages.folders;
  for (fs::path above = folder_;; above = above.parent_path()) {
    searched_.push_back(above);
    if (above == above.parent_path()) break;
  }
  addFolders("ROS_PACKAGE_PATH", "", searched_);
  addFolders("AMENT_PREFIX_PATH", "share", searched_);
}

const std::vector<fs::path>& MeshSearch::foldersOf(const std::string& package) {
  const auto [at, is_new] = folders_of_.try_emplace(package);
  std::vector<fs::path>& out = at->second;
  if (!is_new) return out;
  if (const auto named = packages_.named.find(package); named != packages_.named.end()) {
    out.push_back(named->second);
    return out;
  }
  for (const fs::path& folder : searched_) {
    if (folder.filename() == package || declaredName(folder) == package) out.push_back(folder);
    if (!package.empty()) out.push_back(folder / package);
    std::vector<fs::path> inside;
    std::error_code error;
    for (fs::directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end; !error && it != end;
         it.increment(error))
      if (declaredName(it->path()) == package) inside.push_back(it->path());
    std::sort(inside.begin(), inside.end());
    out.insert(out.end(), inside.begin(), inside.end());
  }
  return out;
}

fs::path MeshSearch::findInPackage(const std::string& package, const fs::path& rest) {
  for (const fs::path& folder : foldersOf(package))
    if (isFile(folder / rest)) return folder / rest;
  return {};
}

fs::path MeshSearch::findAbove(const fs::path& rest, const std::string& taken_to_be, const std::string& advice, const std::string& place) {
  if (rest.empty() || rest.is_absolute()) return {};
  for (const fs::path& folder : searched_) {
    if (!isFile(folder / rest)) continue;
    if (noted_.insert(taken_to_be + folder.string()).second)
      notes_.push_back(place + ": " + taken_to_be + formats::shownName(folder) + ", which holds " + rest.string() + advice + ".");
    return folder / rest;
  }
  return {};
}

fs::path MeshSearch::find(const std::string& name, const std::string& place) {
  std::string slashed = name;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  const std::string spellings[] = {name, slashed, withoutEscapes(slashed)};
  for (const char* scheme : {"package://", "model://"}) {
    if (!slashed.starts_with(scheme)) continue;
    const auto split = [&](const std::string& spelling) {
      const std::string inside = spelling.substr(std::string(scheme).size());
      const std::size_t slash = std::min(inside.find('/'), inside.size());
      return std::pair(inside.substr(0, slash), fs::path(inside.substr(std::min(slash + 1, inside.size()))));
    };
    for (const std::string& spelling : spellings)
      if (const auto [package, rest] = split(spelling); isFile(findInPackage(package, rest))) return findInPackage(package, rest);
    const std::string package = split(slashed).first;
    if (const auto named = packages_.named.find(package); named != packages_.named.end())
      throw formats::FileError(place + ": " + name + " is not in the folder " + formats::shownName(named->second) + " of --package.");
    for (const std::string& spelling : spellings)
      if (fs::path found = findAbove(split(spelling).second, "the package " + package + " is taken to be ",
                                     "; --package " + package + "=FOLDER names another", place);
          !found.empty())
        return found;
    throw formats::FileError(place + ": " + name + " is not found: no folder above the file, of --package, ROS_PACKAGE_PATH or " +
                             "AMENT_PREFIX_PATH is the package " + package + " with this file. Name its folder: --package " + package +
                             "=FOLDER.");
  }
  for (const std::string& spelling : spellings)
    if (fs::path found = folder_ / pathOf(spelling); isFile(found)) return found;
  for (const std::string& spelling : spellings)
    if (fs::path found = findAbove(pathOf(spelling), "the path is taken relative to ", "", place); !found.empty()) return found;
  throw formats::FileError(place + ": the mesh " + (folder_ / pathOf(name)).string() + " does not exist.");
}

}  // namespace spheretree::robot
