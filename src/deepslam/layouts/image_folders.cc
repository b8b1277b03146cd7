#include "deepslam/layouts/image_folders.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <utility>

#include <fmt/format.h>

#include "deepslam/dataset/file_frames.h"
#include "deepslam/formats/tum_lists.h"
#include "deepslam/layouts/layout.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxTimeDifferenceS = 0.02;  // half a frame at 30 Hz, rounded up

bool EndsIn(std::string_view name, std::initializer_list<std::string_view> ends) {
  std::string end = fs::path(name).extension().string();
  std::transform(end.begin(), end.end(), end.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return std::find(ends.begin(), ends.end(), end) != ends.end();
}

NumberedImage ParseName(const std::string& folder, const std::string& name) {
  NumberedImage parsed{folder + "/" + name, std::nullopt, std::nullopt};
  const std::string stem = fs::path(name).stem().string();
  if (const std::size_t dash = stem.rfind('-'); dash != std::string::npos) {
    parsed.number = WholeNumber(std::string_view(stem).substr(0, dash));
    if (parsed.number) parsed.time_us = WholeNumber(std::string_view(stem).substr(dash + 1));
    if (parsed.time_us) return parsed;
  }
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  parsed.number = WholeNumber(
      std::string_view(stem).substr(last_other == std::string::npos ? 0 : last_other + 1));
  return parsed;
}

dataset::TimedFile ToTimed(const NumberedImage& image, std::size_t position) {
  const double time_s =
      image.time_us ? static_cast<double>(*image.time_us) / 1e6
                    : TimeOfNumber(image.number.value_or(static_cast<std::int64_t>(position)));
  return {time_s, image.file, 0};
}

// Images of one number. Empty when the numbers do not name frames: two files of one number, or
// moments that are too far apart.
std::vector<dataset::ImagePair> PairsByNumber(const std::vector<NumberedImage>& colour,
                                              const std::vector<NumberedImage>& depth) {
  std::map<std::int64_t, std::size_t> depth_of;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (!depth[i].number || !depth_of.emplace(*depth[i].number, i).second) return {};
  }
  std::vector<dataset::ImagePair> pairs;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    if (!colour[i].number || (i > 0 && colour[i].number == colour[i - 1].number)) return {};
    const auto found = depth_of.find(*colour[i].number);
    if (found == depth_of.end()) continue;
    pairs.push_back({ToTimed(colour[i], i), ToTimed(depth[found->second], found->second)});
    if (std::abs(pairs.back().colour.time_s - pairs.back().depth.time_s) > kMaxTimeDifferenceS)
      return {};
  }
  return pairs;
}

std::vector<dataset::ImagePair> PairsByTime(const std::vector<NumberedImage>& colour,
                                            const std::vector<NumberedImage>& depth) {
  const auto timed = [](const std::vector<NumberedImage>& images) {
    std::vector<dataset::TimedFile> files;
    for (std::size_t i = 0; i < images.size(); ++i) files.push_back(ToTimed(images[i], i));
    std::ranges::stable_sort(files, {}, &dataset::TimedFile::time_s);
    return files;
  };
  return formats::AssociateByTime(timed(colour), timed(depth), kMaxTimeDifferenceS);
}

// Frames are numbered as depth is.
std::vector<dataset::ImagePair> PairsInOrder(const std::vector<NumberedImage>& colour,
                                             const std::vector<NumberedImage>& depth,
                                             bool numbered) {
  std::vector<dataset::ImagePair> pairs;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const double time_s = TimeOfNumber(numbered ? *depth[i].number : static_cast<std::int64_t>(i));
    pairs.push_back({{time_s, colour[i].file, 0}, {time_s, depth[i].file, 0}});
  }
  return pairs;
}

// By how much the numbers of colour are larger than those of depth, in order; nothing where they
// differ by more than one amount, or carry times.
std::optional<std::int64_t> ShiftOf(const std::vector<NumberedImage>& colour,
                                    const std::vector<NumberedImage>& depth) {
  if (colour.size() != depth.size()) return std::nullopt;
  std::optional<std::int64_t> shift;
  for (std::size_t i = 0; i < colour.size(); ++i) {
    if (!colour[i].number || !depth[i].number || colour[i].time_us) return std::nullopt;
    const std::int64_t own = *colour[i].number - *depth[i].number;
    if (shift && *shift != own) return std::nullopt;
    shift = own;
  }
  return shift;
}

// ".npz (12 files), .txt (1)"; empty for a folder without files.
std::string EndsOfFiles(const fs::path& folder) {
  std::map<std::string, int> counts;
  for (const std::string& name : dataset::ListFiles(folder))
    ++counts[fs::path(name).extension().string()];
  std::string text;
  for (const auto& [end, count] : counts) {
    text += fmt::format("{}{} file{} {}",
                        text.empty() ? "" : ", ",
                        count,
                        count == 1 ? "" : "s",
                        end.empty() ? "without an end" : end);
  }
  return text;
}

Error NoImages(const fs::path& folder, std::string_view read) {
  const std::string others = EndsOfFiles(folder);
  return InvalidInput(
      others.empty()
          ? fmt::format("{}: holds no images; is the capture unpacked completely?", folder.string())
          : fmt::format("{}: holds no {} but {}; convert them", folder.string(), read, others));
}

std::vector<dataset::ImagePair> ChoosePairs(const std::vector<NumberedImage>& colour,
                                            const std::vector<NumberedImage>& depth,
                                            bool has_times,
                                            std::optional<std::int64_t> shift) {
  if (shift.value_or(0) != 0) return PairsInOrder(colour, depth, true);
  std::vector<dataset::ImagePair> pairs = PairsByNumber(colour, depth);
  if (pairs.empty() && has_times) pairs = PairsByTime(colour, depth);
  if (pairs.empty() && colour.size() == depth.size()) pairs = PairsInOrder(colour, depth, false);
  return pairs;
}

}  // namespace

bool IsColourName(std::string_view name) { return EndsIn(name, {".png", ".jpg", ".jpeg"}); }

bool IsDepthName(std::string_view name) {
  return EndsIn(name, {".png", ".pgm", ".tif", ".tiff", ".exr", ".npy"});
}

std::optional<std::int64_t> WholeNumber(std::string_view text) {
  if (text.empty() || text.size() > 18 ||
      text.find_first_not_of("0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  std::int64_t number = 0;
  for (const char c : text) number = 10 * number + (c - '0');
  return number;
}

std::vector<NumberedImage> ListImages(const fs::path& capture,
                                      const std::string& folder,
                                      bool (*is_image)(std::string_view name)) {
  std::vector<NumberedImage> images;
  for (const std::string& name : dataset::ListFiles(capture / folder)) {
    if (is_image(name)) images.push_back(ParseName(folder, name));
  }
  const bool numbered = std::all_of(
      images.begin(), images.end(), [](const NumberedImage& image) { return image.number; });
  if (numbered) std::ranges::stable_sort(images, {}, &NumberedImage::number);
  return images;
}

std::map<std::int64_t, std::string> FilesByNumber(const fs::path& folder,
                                                  bool (*is_image)(std::string_view name)) {
  std::map<std::int64_t, std::string> names;
  for (const std::string& name : dataset::ListFiles(folder)) {
    const std::optional<std::int64_t> number = WholeNumber(fs::path(name).stem().string());
    if (!number || !is_image(name)) continue;
    // Of two that hold the same, the one that every recorder writes.
    const bool is_png = EndsIn(name, {".png"});
    const auto [at, is_new] = names.emplace(*number, name);
    if (!is_new && is_png) at->second = name;
  }
  return names;
}

Result<FolderPairs> PairFolders(const fs::path& capture,
                                const std::string& colour_folder,
                                const std::string& depth_folder,
                                std::vector<std::string>& warnings) {
  const std::vector<NumberedImage> colour = ListImages(capture, colour_folder, IsColourName);
  if (colour.empty()) return NoImages(capture / colour_folder, "PNG or JPEG images");
  const std::vector<NumberedImage> depth = ListImages(capture, depth_folder, IsDepthName);
  if (depth.empty())
    return NoImages(capture / depth_folder, "depth images (PNG, PGM, TIFF, EXR, NPY)");
  FolderPairs read;
  for (std::size_t i = 0; i < colour.size(); ++i) read.position.emplace(colour[i].file, i);
  read.has_times = std::all_of(
      depth.begin(), depth.end(), [](const NumberedImage& image) { return image.time_us; });
  const std::optional<std::int64_t> shift = ShiftOf(colour, depth);
  read.pairs = ChoosePairs(colour, depth, read.has_times, shift);
  if (read.pairs.empty()) {
    return InvalidInput(fmt::format(
        "{}: {} colour and {} depth images of which none belong together; give the two of a frame "
        "one number",
        capture.string(),
        colour.size(),
        depth.size()));
  }
  if (shift.value_or(0) != 0) {
    warnings.push_back(fmt::format(
        "{}: colour is numbered from {}, depth from {}; as many of both, so they were paired in "
        "order (ffmpeg counts from 1 unless told -start_number 0)",
        capture.string(),
        *colour.front().number,
        *depth.front().number));
  }
  if (read.pairs.size() < std::max(colour.size(), depth.size())) {
    warnings.push_back(fmt::format("{}: {} colour and {} depth images make {} frames",
                                   capture.string(),
                                   colour.size(),
                                   depth.size(),
                                   read.pairs.size()));
  }
  return read;
}

std::string FirstFolder(const fs::path& capture, std::initializer_list<std::string_view> names) {
  std::error_code ignored;
  for (const std::string_view name : names) {
    if (fs::is_directory(capture / name, ignored)) return std::string(name);
  }
  return "";
}

std::string FileOfCamera(const fs::path& folder) {
  std::string first;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    std::string small = name;
    std::ranges::transform(
        small, small.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool speaks = small.find("intrinsic") != std::string::npos ||
                        small.find("calib") != std::string::npos ||
                        small.find("camera") != std::string::npos || small == "k.txt";
    if (speaks && !name.starts_with('.') && (first.empty() || name < first)) first = name;
  }
  return first;
}

}  // namespace deepslam::layouts
