// SPDX-License-Identifier: Apache-2.0
#include "text/other_content.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t kSearched = 65536;  // first bytes of a file that are looked at

struct Magic {
  std::size_t at;  // [bytes]
  std::string_view bytes, what, next;
};

// In `next`, NAME stands for the name of the file. Commands are of Debian packages.
constexpr std::string_view kImport = "Convert it: spheretree-import NAME -o mesh.obj --trusted.";
constexpr std::string_view kPoints = "It holds points without faces: reconstruct the surface and export it as STL or PLY.";
constexpr std::string_view kSegment = "Segment it, for example in 3D Slicer, and export the segment as STL.";
constexpr std::string_view kSurface = "Export its surface as STL, for example in ParaView by File > Save Data.";
constexpr std::string_view kGmsh = "Make a mesh of it, for example with gmsh: gmsh -2 NAME -o mesh.stl.";
constexpr std::string_view kPicture = "A picture holds no surface. Give the mesh.";
constexpr std::array kMagics{
    Magic{0, "version https://git-lfs"sv, "a pointer of Git LFS, without the mesh", "Fetch the mesh in its repository: git lfs pull."},
    Magic{0, "version https://hawser"sv, "a pointer of Git LFS, without the mesh", "Fetch the mesh in its repository: git lfs pull."},
    Magic{0, "/annex/objects/"sv, "a pointer of git-annex, without the mesh", "Fetch the mesh in its repository: git annex get NAME."},
    Magic{0, "\x1f\x8b"sv, "compressed by gzip", "Unpack it: gunzip < NAME > mesh."},
    Magic{0, "BZh"sv, "compressed by bzip2", "Unpack it: bunzip2 < NAME > mesh."},
    Magic{0,
          "\xfd"
          "7zXZ\0"sv,
          "compressed by xz", "Unpack it: unxz < NAME > mesh."},
    Magic{0, "\x28\xb5\x2f\xfd"sv, "compressed by zstd", "Unpack it: unzstd < NAME > mesh."},
    Magic{0, "7z\xbc\xaf\x27\x1c"sv, "a 7z archive", "Unpack it: 7z x NAME."},
    Magic{0, "Rar!\x1a\x07"sv, "a RAR archive", "Unpack it: unar NAME."},
    Magic{257, "ustar"sv, "a tar archive", "Unpack it: tar xf NAME."},
    Magic{0, "\0\x05\x16\x07"sv, "a companion file of macOS (AppleDouble), without the mesh", "Take the file without ._ before its name."},
    Magic{128, "DICM"sv, "a DICOM file", kSegment},
    Magic{0, "NRRD0"sv, "a volume picture (NRRD)", kSegment},
    Magic{344, "n+1\0"sv, "a volume picture (NIfTI)", kSegment},
    Magic{0, "ObjectType = Image"sv, "a volume picture (MetaImage)", kSegment},
    Magic{0, "# vtk DataFile"sv, "a VTK file", kSurface},
    Magic{0, "\x89HDF"sv, "an HDF5 file", kSurface},
    Magic{0, "$MeshFormat"sv, "a mesh of gmsh", "Export its surface as STL: gmsh -save NAME -o mesh.stl."},
    Magic{0, "MeshVersionFormatted"sv, "a mesh of Medit", "Export its surface as STL: gmsh -save NAME -o mesh.stl."},
    Magic{0, "ISO-10303-21"sv, "a STEP file, which holds curved faces and no mesh", kGmsh},
    Magic{72, "S      1"sv, "an IGES file, which holds curved faces and no mesh", kGmsh},
    Magic{0, "DBRep_DrawableShape"sv, "a BREP file, which holds curved faces and no mesh", kGmsh},
    Magic{0, "3D Geometry File Format"sv, "a Rhino file (3DM)", "Open it in Rhino and export it as STL or OBJ."},
    Magic{0, "Kaydara FBX Binary"sv, "an FBX file", kImport},
    Magic{0, "; FBX"sv, "an FBX file", kImport},
    Magic{0, "BLENDER"sv, "a Blender file", "Open it in Blender and export it as STL, PLY, OBJ or GLB."},
    Magic{0, "DRACO"sv, "a mesh compressed by Draco", "Unpack it: draco_decoder -i NAME -o mesh.ply."},
    Magic{0, "OCTM"sv, "an OpenCTM file", "Open it in MeshLab and export it as PLY."},
    Magic{0, "#VRML"sv, "a VRML file", "Open it in MeshLab and export it as PLY."},
    Magic{0, "#usda"sv, "a USD file", "Open it in Blender and export it as STL, PLY, OBJ or GLB."},
    Magic{0, "PXR-USDC"sv, "a USD file", "Open it in Blender and export it as STL, PLY, OBJ or GLB."},
    Magic{0, "# .PCD"sv, "a point cloud (PCD)", kPoints},
    Magic{0, "\x93NUMPY"sv, "an array of numpy", "Write its vertices and faces as a mesh file, or build from Python: spheretree.build()."},
    Magic{0, "%PDF"sv, "a PDF document", "Give the mesh."},
    Magic{0, "\x89PNG"sv, "a picture (PNG)", kPicture},
    Magic{0, "\xff\xd8\xff"sv, "a picture (JPEG)", kPicture},
    Magic{0, "GIF8"sv, "a picture (GIF)", kPicture},
    Magic{0, "II*\0"sv, "a picture (TIFF)", kPicture},
    Magic{0, "MM\0*"sv, "a picture (TIFF)", kPicture},
    Magic{0, "SQLite format 3"sv, "a database (SQLite)", "Give the mesh."},
    Magic{0, "404: Not Found"sv, "the answer of a server that has no such file", "Download the mesh again, from an address that has it."}};

// Lower case; found in a text that begins with '<'.
constexpr std::array kMarkup{Magic{0, "<!doctype html"sv, "a web page (HTML)", ""},
                             Magic{0, "<html"sv, "a web page (HTML)", ""},
                             Magic{0, "<vtkfile"sv, "a VTK file", kSurface},
                             Magic{0, "<collada"sv, "a Collada file (DAE)", kImport},
                             Magic{0, "<x3d"sv, "an X3D file", kImport},
                             Magic{0, "<amf"sv, "an AMF file", kImport},
                             Magic{0, "<hps"sv, "a scan of 3Shape (DCM)", "Export it as STL or PLY from the program of the scanner."},
                             Magic{0, "<svg"sv, "a drawing (SVG)", kPicture},
                             Magic{0, "<robot"sv, "a robot (URDF)", "Give it to spheretree robot."},
                             Magic{0, "<mujoco"sv, "a robot (MJCF)", "Give the meshes that it names."}};

OtherContent filled(const Magic& magic, const std::string& name) {
  std::string next(magic.next);
  if (const std::size_t at = next.find("NAME"); at != std::string::npos) next.replace(at, 4, name);
  return {std::string(magic.what), next};
}

std::optional<OtherContent> markupOf(std::string_view start, const std::string& name) {
  std::string text(start.substr(0, 4096));
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const Magic& magic : kMarkup) {
    if (text.find(magic.bytes) == std::string::npos) continue;
    if (!magic.next.empty()) return filled(magic, name);
    return OtherContent{std::string(magic.what), "Download the mesh itself, not the page that shows it; on GitHub by Download raw file."};
  }
  if (text.starts_with("<?xml"))
    return OtherContent{"an XML file, but no mesh that is known", "Give a mesh: .obj, .stl, .ply, .off, .gltf or .glb."};
  return std::nullopt;
}

}  // namespace

std::optional<OtherContent> otherContentOf(std::span<const char> bytes, const std::string& name) {
  std::string_view start(bytes.data(), std::min(bytes.size(), kSearched));
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);
  if (start.starts_with("PK\x03\x04") || start.starts_with("PK\x05\x06")) {
    const std::string_view whole(bytes.data(), bytes.size());
    if (whole.find("3D/3dmodel.model") != std::string_view::npos) return filled({0, "", "a 3MF file", kImport}, name);
    return filled({0, "", "a zip archive", "Unpack it: unzip NAME."}, name);
  }
  for (const Magic& magic : kMagics)
    if (start.size() > magic.at && start.substr(magic.at).starts_with(magic.bytes)) return filled(magic, name);
  while (!start.empty() && (isBlank(start.front()) || start.front() == '\n')) start.remove_prefix(1);
  return start.starts_with('<') ? markupOf(start, name) : std::nullopt;
}

}  // namespace spheretree::formats
