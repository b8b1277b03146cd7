// Captures that are two folders of images: which files there are, and which belong together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/dataset/image_pair.h"

namespace deepslam::layouts {

// By the end of the name, in small or capital letters.
[[nodiscard]] bool IsColourName(std::string_view name);  // PNG, JPEG
[[nodiscard]] bool IsDepthName(std::string_view name);   // PNG, PGM, TIFF, EXR, NPY

// Digits alone, at most 18.
[[nodiscard]] std::optional<std::int64_t> WholeNumber(std::string_view text);

// An image and what its name says: "frame000012", or Redwood's "0000012-000000400000" with
// microseconds.
struct NumberedImage {
  std::string file;  // relative to the capture
  std::optional<std::int64_t> number;
  std::optional<std::int64_t> time_us;
};
// In the order of their numbers, where all have one, else of their names.
[[nodiscard]] std::vector<NumberedImage> ListImages(const std::filesystem::path& capture,
                                                    const std::string& folder,
                                                    bool (*is_image)(std::string_view name));

// Files of a folder by the number that is all of their name.
[[nodiscard]] std::map<std::int64_t, std::string> FilesByNumber(
    const std::filesystem::path& folder, bool (*is_image)(std::string_view name));

struct FolderPairs {
  std::vector<dataset::ImagePair> pairs;
  std::map<std::string, std::size_t>
      position;  // of a colour file among all, where poses count them
  bool has_times = false;
};

// Images of one number, of one time where the names carry it; in order, where there are as many of
// both and their numbers are shifted against each other, or say nothing. Warnings tell of shifts
// and of images left over.
[[nodiscard]] Result<FolderPairs> PairFolders(const std::filesystem::path& capture,
                                              const std::string& colour_folder,
                                              const std::string& depth_folder,
                                              std::vector<std::string>& warnings);

// The first of these that is a folder there; empty where none is.
[[nodiscard]] std::string FirstFolder(const std::filesystem::path& capture,
                                      std::initializer_list<std::string_view> names);

// A file or folder whose name tells that it speaks of the camera: where a layout does not read it,
// no camera may be guessed. Empty where there is none.
[[nodiscard]] std::string FileOfCamera(const std::filesystem::path& folder);

}  // namespace deepslam::layouts
