// Record3D's export "EXR + RGB": rgb/0.jpg, depth/0.exr (m, coarser than colour, seen from its
// place) and metadata.json: "K" column by column for images of "w" x "h", "poses" as
// qx qy qz qw tx ty tz of ARKit's camera (y up, z back), "fps" and, where the app has written them,
// "frameTimestamps" and "perFrameIntrinsicCoeffs" (fx fy cx cy). scripts/import_recording.py makes
// the same of a .r3d, with depth/0.png and confidence/0.png (0 low, 1 medium, 2 high).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/dataset/read_bytes.h"
#include "deepslam/geometry/max_position.h"
#include "deepslam/layouts/image_folders.h"
#include "deepslam/layouts/open_files.h"

namespace deepslam::layouts {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMaxTimeS = 1e11;  // s since 1970: 3,000 years; what is beyond is no time
constexpr int kMinConfidence = 1;   // medium

std::optional<fs::path> FindMetadata(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name : {"metadata.json", "metadata"}) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

// The numbers of a list of exactly `count`; nothing where it is none.
std::optional<std::vector<double>> Numbers(const json& list, std::size_t count) {
  if (!list.is_array() || list.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const json& number : list) {
    if (!number.is_number()) return std::nullopt;
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

const json& Member(const json& root, const char* name) {
  static const json kNone;
  const auto found = root.find(name);
  return found == root.end() ? kNone : *found;
}

// The matrix as 9 numbers column by column, whether it was written so, by rows, or as three rows.
std::optional<std::vector<double>> ParseMatrix(const json& list) {
  std::optional<std::vector<double>> k = Numbers(list, 9);
  if (!k && list.is_array() && list.size() == 3) {
    k.emplace();
    for (const json& row : list) {
      const auto numbers = Numbers(row, 3);
      if (!numbers) return std::nullopt;
      k->insert(k->end(), numbers->begin(), numbers->end());
    }
  }
  const bool by_rows = k && (*k)[6] == 0 && (*k)[7] == 0 && (*k)[2] > 0 && (*k)[5] > 0;
  if (by_rows) k = {{(*k)[0], 0, 0, 0, (*k)[4], 0, (*k)[2], (*k)[5], 1}};
  return k;
}

struct Metadata {
  PinholeCamera camera;
  double frames_per_s = 0;
  std::vector<std::optional<Pose3>> poses;  // by the number of a frame
  std::vector<double> times_s;
  std::vector<PinholeCamera> cameras;
};

Result<PinholeCamera> ParseCamera(const json& root, const fs::path& file) {
  const auto k = ParseMatrix(Member(root, "K"));
  const json& width = Member(root, "w");
  const json& height = Member(root, "h");
  if (!k || !width.is_number() || !height.is_number()) {
    return InvalidInput(fmt::format(
        "{}: fields 'K' (9 numbers, column by column), 'w' and 'h' have to be there: is it "
        "Record3D's?",
        file.string()));
  }
  if (!(width.get<double>() >= 1 && width.get<double>() < 1e5 && height.get<double>() >= 1 &&
        height.get<double>() < 1e5)) {
    return InvalidInput(
        fmt::format("{}: fields 'w' and 'h' are no size of an image", file.string()));
  }
  const PinholeCamera camera{static_cast<int>(width.get<double>()),
                             static_cast<int>(height.get<double>()),
                             (*k)[0],
                             (*k)[4],
                             (*k)[6],
                             (*k)[7]};
  const Status plausible = dataset::CheckCamera(camera, file, "K");
  if (!plausible) return plausible.error();
  return camera;
}

std::optional<Pose3> ParsePose(const json& list) {
  const auto n = Numbers(list, 7);
  if (!n) return std::nullopt;
  const Eigen::Quaterniond rotation((*n)[3], (*n)[0], (*n)[1], (*n)[2]);
  const Eigen::Vector3d position_m((*n)[4], (*n)[5], (*n)[6]);
  const double norm = rotation.norm();
  if (!(norm > 0.5 && norm < 2.0) || !position_m.allFinite() ||
      position_m.cwiseAbs().maxCoeff() > kMaxPositionM) {
    return std::nullopt;
  }
  return formats::OfOpenGlCamera({rotation.normalized(), position_m});
}

Result<Metadata> ParseMetadata(const std::string& text, const fs::path& file) {
  const json root = json::parse(text, nullptr, false);
  if (!root.is_object())
    return InvalidInput(fmt::format("{}: is not a JSON object (damaged?)", file.string()));
  Metadata metadata;
  const Result<PinholeCamera> camera = ParseCamera(root, file);
  if (!camera) return camera.error();
  metadata.camera = *camera;
  const json& rate = Member(root, "fps");
  if (rate.is_number() && rate.get<double>() > 0) metadata.frames_per_s = rate.get<double>();
  for (const json& pose : Member(root, "poses")) metadata.poses.push_back(ParsePose(pose));
  for (const json& time : Member(root, "frameTimestamps")) {
    const double time_s = time.is_number() ? time.get<double>() : kMaxTimeS;
    if (!(std::abs(time_s) < kMaxTimeS)) {
      metadata.times_s.clear();
      break;
    }
    metadata.times_s.push_back(time_s);
  }
  for (const json& own : Member(root, "perFrameIntrinsicCoeffs")) {
    const auto k = Numbers(own, 4);
    PinholeCamera of_frame = metadata.camera;
    if (k) {
      of_frame.fx = (*k)[0];
      of_frame.fy = (*k)[1];
      of_frame.cx = (*k)[2];
      of_frame.cy = (*k)[3];
    }
    const Status plausible = dataset::CheckCamera(of_frame, file, "perFrameIntrinsicCoeffs");
    if (!plausible) return plausible.error();
    metadata.cameras.push_back(of_frame);
  }
  return metadata;
}

// Numbers of the files count the frames of the lists.
std::size_t NumberOf(const dataset::ImagePair& pair) {
  const auto number = WholeNumber(fs::path(pair.depth.file).stem().string());
  return static_cast<std::size_t>(number.value_or(0));
}

// True where every frame has a time: of the list, where that ascends from frame to frame, else by
// the frame's number.
bool SetTimes(const Metadata& metadata,
              const fs::path& file,
              std::vector<dataset::ImagePair>& pairs,
              std::vector<std::string>& warnings) {
  double last_s = -kMaxTimeS;
  const bool ascends = std::ranges::all_of(pairs, [&](const dataset::ImagePair& pair) {
    const std::size_t number = NumberOf(pair);
    if (number >= metadata.times_s.size() || metadata.times_s[number] <= last_s) return false;
    last_s = metadata.times_s[number];
    return true;
  });
  if (!ascends && !(metadata.frames_per_s > 0)) return false;
  if (!ascends && !metadata.times_s.empty()) {
    warnings.push_back(fmt::format(
        "{}: field 'frameTimestamps' has no ascending time for every frame; times are by 'fps', {}",
        file.string(),
        metadata.frames_per_s));
  }
  for (dataset::ImagePair& pair : pairs) {
    const std::size_t number = NumberOf(pair);
    const double time_s =
        ascends ? metadata.times_s[number] : static_cast<double>(number) / metadata.frames_per_s;
    pair.colour.time_s = pair.depth.time_s = time_s;
  }
  return true;
}

// One pose for all frames is what the app writes where it has none (the face's camera).
formats::FramePoses PosesOf(const Metadata& metadata,
                            const fs::path& file,
                            const std::vector<dataset::ImagePair>& pairs,
                            std::vector<std::string>& warnings) {
  formats::FramePoses poses;
  for (const dataset::ImagePair& pair : pairs) {
    const std::size_t number = NumberOf(pair);
    poses.push_back(number < metadata.poses.size() ? metadata.poses[number] : std::nullopt);
  }
  const bool moves = std::ranges::any_of(poses, [&](const auto& pose) { return pose != poses[0]; });
  if (moves || poses.size() < 2 || !poses[0]) return poses;
  warnings.push_back(fmt::format(
      "{}: field 'poses' is the same for all frames, so there are none: tracking finds them",
      file.string()));
  return formats::FramePoses(poses.size());
}

// Of images that are finer or coarser than the metadata says.
Status ScaleCameras(const fs::path& folder,
                    const fs::path& file,
                    const std::vector<dataset::ImagePair>& pairs,
                    Metadata& metadata,
                    std::vector<std::string>& warnings) {
  const Result<dataset::ImageSize> size = FirstColourSize(folder, pairs);
  if (!size) return Ok();  // nothing is readable: told when frames are looked at
  const PinholeCamera stated = metadata.camera;
  if (size->width == stated.width && size->height == stated.height) return Ok();
  const auto scale = [&](PinholeCamera& camera) -> Status {
    const Result<PinholeCamera> scaled = SameView(camera, *size, folder / pairs[0].colour.file);
    if (!scaled) return scaled.error();
    camera = *scaled;
    return Ok();
  };
  for (PinholeCamera& camera : metadata.cameras) {
    const Status scaled = scale(camera);
    if (!scaled) return scaled;
  }
  const Status scaled = scale(metadata.camera);
  if (!scaled) return scaled;
  warnings.push_back(
      fmt::format("{}: is of images of {} x {} px, they have {} x {}: scaled to them",
                  file.string(),
                  stated.width,
                  stated.height,
                  size->width,
                  size->height));
  return Ok();
}

void AddConfidence(const LayoutSource& source,
                   const std::vector<dataset::ImagePair>& pairs,
                   dataset::ImageForm& form) {
  const auto files = FilesByNumber(source.path / "confidence", IsColourName);
  if (files.empty()) return;
  form.min_confidence = source.settings.min_confidence.value_or(kMinConfidence);
  for (const dataset::ImagePair& pair : pairs) {
    const auto found = files.find(static_cast<std::int64_t>(NumberOf(pair)));
    form.confidence.push_back(found == files.end() ? "" : "confidence/" + found->second);
  }
}

}  // namespace

LayoutMatch MatchRecord3d(const fs::path& path) {
  std::error_code ignored;
  return MatchOfPieces({{FindMetadata(path).has_value(), "metadata.json"},
                        {fs::is_directory(path / "rgb", ignored), "rgb/"},
                        {fs::is_directory(path / "depth", ignored), "depth/"}});
}

Result<OpenedLayout> OpenRecord3d(const LayoutSource& source) {
  const fs::path& folder = source.path;
  std::vector<std::string> warnings;
  Result<FolderPairs> read = PairFolders(folder, "rgb", "depth", warnings);
  if (!read) return read.error();
  const fs::path file = FindMetadata(folder).value_or(folder / "metadata.json");
  Result<std::string> text = dataset::ReadTextFile(file);
  if (!text) return text.error();
  Result<Metadata> metadata = ParseMetadata(*text, file);
  if (!metadata) return metadata.error();
  const Status scaled = source.settings.has_camera()
                            ? Ok()
                            : ScaleCameras(folder, file, read->pairs, *metadata, warnings);
  if (!scaled) return scaled.error();
  const PinholeCamera& camera = metadata->camera;
  Result<SettledImages> settled = SettleImages(
      source, {camera, camera, Pose3(), 1000}, read->pairs, warnings, CoarserDepth::kUsual);
  if (!settled) return settled.error();
  AddConfidence(source, read->pairs, settled->form);
  FilesOfLayout files{"record3d",
                      {{"metadata", *text}},
                      {},
                      PosesOf(*metadata, file, read->pairs, warnings),
                      file.string(),
                      *std::move(settled),
                      {},
                      false};
  files.has_times = SetTimes(*metadata, file, read->pairs, warnings);
  for (const dataset::ImagePair& pair : read->pairs) {
    if (metadata->cameras.empty()) break;
    const std::size_t number = NumberOf(pair);
    files.optics.colour_cameras.push_back(
        number < metadata->cameras.size() ? metadata->cameras[number] : camera);
  }
  files.pairs = std::move(read->pairs);
  return OpenFiles(source, std::move(files), std::move(warnings));
}

}  // namespace deepslam::layouts
