// Captures whose images are single files in a folder, one pair per frame.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/sha256.h"
#include "deepslam/dataset/image_pair.h"
#include "deepslam/dataset/stored_frames.h"
#include "deepslam/dataset/video_file.h"

namespace deepslam::dataset {

// What there is to the images beyond two files a frame.
struct ImageForm {
  double raw_per_real = 0;              // of depth files with real numbers (ReadDepthFile)
  bool rotated_bits = false;            // depth's lowest three bits stand highest (SUN3D)
  std::vector<std::string> confidence;  // files of 8 bits a pixel of depth, per frame; "": none
  int min_confidence = 0;               // depth with less becomes kNoDepth
  // Colour comes out of a video; the frames' colour files are names alone then.
  std::shared_ptr<VideoFile> video;
  std::vector<int> video_frames;  // per frame
};

// `world_from_colour` has one entry per pair.
std::unique_ptr<const StoredFrames> MakeFileFrames(
    const std::filesystem::path& folder,
    const CaptureCameras& cameras,
    std::vector<ImagePair> pairs,
    const std::vector<std::optional<Pose3>>& world_from_colour,
    ImageForm form = {});

// A warning about pairs whose files are missing; an error when that is more than half of them.
Status CheckFilesExist(const std::filesystem::path& folder,
                       const std::vector<ImagePair>& pairs,
                       std::vector<std::string>& warnings);

// A text that belongs to the capture: part of its hash. No content: the file does not exist. It is
// not held: lists and poses of a long capture are a hundred megabytes.
struct NamedText {
  NamedText(std::string_view text_name, const std::optional<std::string>& content)
      : name(text_name), digest(content ? Sha256Hex(*content) : "none") {}

  std::string_view name;
  std::string digest;
};

// SHA-256 over the texts and over times, names and contents of all images, in order. `tag` tells
// layouts apart. Contents enter by their own digests, so that files can be hashed in parallel; a
// file that cannot be read enters as such. kFailed when the machine does not give one
// (read_bytes.h).
Result<std::string> HashFiles(std::string_view tag,
                              std::span<const NamedText> texts,
                              const std::filesystem::path& folder,
                              const std::vector<ImagePair>& pairs);

// SHA-256 of a file of any size, read piecewise.
Result<std::string> HashLargeFile(const std::filesystem::path& file);

// Text of an optional file: nothing when it does not exist.
Result<std::optional<std::string>> ReadOptional(const std::filesystem::path& file);

// Names of the files of a folder (not of folders in it), sorted; empty when it cannot be listed.
// Names that begin with a dot are left out: macOS puts "._NAME" beside every file of an archive.
std::vector<std::string> ListFiles(const std::filesystem::path& folder);

}  // namespace deepslam::dataset
