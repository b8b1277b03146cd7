#include "deepslam/formats/recognise_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <string_view>

#include "deepslam/dataset/read_bytes.h"

namespace deepslam::formats {
namespace {

// Schemas of databases and titles of recordings stand within this much.
constexpr std::uintmax_t kLookedAtBytes = 1 << 16;

struct Kind {
  std::size_t at = 0;
  std::string_view bytes;
  std::string_view words;
};

constexpr std::string_view kUnpack = "unpack it and name the folder that comes out";

constexpr std::string_view kImport =
    "scripts/import_recording.py makes a capture of it, whose folder can be named here";

constexpr std::array<Kind, 22> kKinds = {{
    {0, "\x1f\x8b", "a gzip archive (.tgz, .tar.gz)"},
    {0, "BZh", "a bzip2 archive (.tar.bz2)"},
    {0,
     std::string_view("\xfd"
                      "7zXZ\0",
                      6),
     "an xz archive (.tar.xz)"},
    {0, "\x28\xb5\x2f\xfd", "a zstd archive (.tar.zst)"},
    {0, "7z\xbc\xaf\x27\x1c", "a 7-Zip archive"},
    {0, "Rar!\x1a\x07", "a RAR archive"},
    {257, "ustar", "a tar archive"},
    {0, "#ROSBAG V2.0", "a bag of ROS 1 (a RealSense viewer writes these too)"},
    {0, "\x89MCAP0\r\n", "a recording of ROS 2 (MCAP)"},
    {0,
     "NI10",
     "a recording of OpenNI (.oni): export its images by OpenNI's tools, into color/ and "
     "depth/"},
    {0, "ply\n", "a point cloud or mesh, no capture: name the folder with the images"},
    {0, "ply\r\n", "a point cloud or mesh, no capture: name the folder with the images"},
    {0, "\x89PNG\r\n\x1a\n", "one image: name the folder of the capture"},
    {0, "\xff\xd8\xff", "one image: name the folder of the capture"},
    {4, "ftyp", "a video, which has no depth: name the folder of the capture"},
    {8, "AVI LIST", "a video, which has no depth: name the folder of the capture"},
    {0, "\x04\x22\x4d\x18", "an lz4 archive (.lz4)"},
    {0,
     "\x89HDF\r\n\x1a\n",
     "an HDF5 file: write its images into color/ and depth/ (PNG of 16 bits)"},
    {0,
     "MATLAB 5.0 MAT-file",
     "a file of MATLAB: write its images into color/ and depth/ (PNG of 16 bits)"},
    {0,
     "MATLAB 7.3 MAT-file",
     "a file of MATLAB: write its images into color/ and depth/ (PNG of 16 bits)"},
    {0, "glTF", "a point cloud or mesh, no capture: name the folder with the images"},
    {0, "%PDF", "a document, no capture"},
}};

bool Has(std::string_view head, std::string_view text) {
  return head.find(text) != std::string_view::npos;
}

std::string SmallEnd(const std::filesystem::path& file) {
  std::string end = file.extension().string();
  std::ranges::transform(
      end, end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return end;
}

// Names of an archive's first files stand in its beginning.
std::string Zip(std::string_view head, const std::filesystem::path& file) {
  if (SmallEnd(file) == ".r3d" || Has(head, "rgbd/"))
    return "a recording of Record3D: " + std::string(kImport);
  return "a zip archive: " + std::string(kUnpack);
}

// ROS 2 and RTAB-Map both keep SQLite databases.
std::string Database(std::string_view head, const std::filesystem::path& file) {
  if (Has(head, "CREATE TABLE topics") || SmallEnd(file) == ".db3")
    return "a recording of ROS 2 (SQLite): " + std::string(kImport);
  return "a database (of RTAB-Map? It is read where its name ends with .db and it holds images; "
         "else export it: rtabmap-export --images_id --poses_camera --poses_format 10)";
}

// Matroska: Azure Kinect's recorder says so in tags and names of tracks.
std::string Matroska(std::string_view head, const std::filesystem::path& file) {
  if (Has(head, "K4A") || Has(head, "k4a") || SmallEnd(file) == ".mkv") {
    return "a recording of an Azure Kinect: " + std::string(kImport);
  }
  return "a video, which has no depth: name the folder of the capture";
}

// Recordings that begin with nothing of their own.
std::optional<std::string> ByName(const std::filesystem::path& file) {
  const std::string end = SmallEnd(file);
  if (end == ".svo" || end == ".svo2")
    return "a recording of a ZED: export it by its SDK, into color/ and depth/ (PNG of 16 bits)";
  if (end == ".klg")
    return "a log of Kintinuous: write its images into color/ and depth/ (PNG of 16 bits)";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> WhatIsToBeDone(const std::filesystem::path& file) {
  std::error_code code;
  if (std::filesystem::is_directory(file / "rgbd", code))
    return "a recording of Record3D, unpacked: " + std::string(kImport);
  const std::uintmax_t size = std::filesystem::file_size(file, code);
  if (code || size == 0) return std::nullopt;
  const Result<std::string> read = dataset::ReadFilePiece(file, 0, std::min(kLookedAtBytes, size));
  if (!read) return std::nullopt;
  const std::string_view head = *read;
  if (head.starts_with("PK\x03\x04")) return Zip(head, file);
  if (head.starts_with("SQLite format 3")) return Database(head, file);
  if (head.starts_with("\x1a\x45\xdf\xa3")) return Matroska(head, file);
  for (const Kind& kind : kKinds) {
    if (head.size() < kind.at || !head.substr(kind.at).starts_with(kind.bytes)) continue;
    std::string words(kind.words);
    if (words.find("archive") != std::string::npos) words += ": " + std::string(kUnpack);
    if (words.find("of ROS") != std::string::npos) words += ": " + std::string(kImport);
    return words;
  }
  return ByName(file);
}

}  // namespace deepslam::formats
