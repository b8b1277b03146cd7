#include "deepslam/artifact/trajectory_files.h"

#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"
#include "deepslam/core/text_numbers.h"

namespace deepslam::artifact {
namespace {

constexpr JsonFormat kFormat{"deepslam/frames", 1};
// Time, translation, quaternion: the TUM RGB-D benchmark's format.
constexpr std::size_t kTumColumns = 8;

Result<StampedPose> DecodeTumLine(std::span<const std::string_view> words) {
  if (words.size() != kTumColumns) {
    return InvalidInput(fmt::format(
        "has {} columns, must have {} (time tx ty tz qx qy qz qw)", words.size(), kTumColumns));
  }
  double n[kTumColumns];
  for (std::size_t i = 0; i < kTumColumns; ++i) {
    const std::optional<double> number = ParseNumber(words[i]);
    if (!number) return InvalidInput(fmt::format("\"{}\" is not a finite number", words[i]));
    n[i] = *number;
  }
  StampedPose pose{n[0], {Eigen::Quaterniond(n[7], n[4], n[5], n[6]), {n[1], n[2], n[3]}}};
  const double norm = pose.world_from_camera.rotation.norm();
  // Other programs print few digits; more than a percent off is no rotation.
  if (std::abs(norm - 1) > 0.01)
    return InvalidInput(fmt::format("quaternion has norm {}, must be 1", norm));
  if (std::abs(norm - 1) > 1e-9) pose.world_from_camera.rotation.normalize();
  return pose;
}

struct ComposedEdge {
  FrameIdx i;
  FrameIdx j;
};
struct FramesFile {
  std::vector<TrackedFrame> frames;  // all but the poses, which the TUM text has
  std::vector<FrameIdx> keyframes;
  std::vector<ComposedEdge> composed_edges;
};

}  // namespace

void Describe(JsonVisitor& visitor, TrackedFrame& frame) {
  visitor.Field("frame", frame.frame);
  visitor.Field("time_s", frame.time_s);
  visitor.Field("status", frame.status);
  visitor.Maybe("keyframe", frame.keyframe);
  visitor.Field("rmse_m", frame.rmse_m);
  visitor.Field("inlier_share", frame.inlier_share);
}

void Describe(JsonVisitor& visitor, ComposedEdge& edge) { visitor.Columns(edge.i, edge.j); }

void Describe(JsonVisitor& visitor, FramesFile& file) {
  visitor.Table("frames", file.frames);
  visitor.Field("keyframes", file.keyframes);
  visitor.Field("composed_edges", file.composed_edges);
}

namespace {

// What is wrong with entry `index`; empty: nothing.
std::string FaultOf(const TrackedFrame& frame,
                    std::size_t index,
                    std::span<const StampedPose> poses) {
  // Frames are addressed by their index all over the program.
  if (frame.frame.value != static_cast<int>(index))
    return fmt::format("is frame {}, must be {}", frame.frame.value, index);
  if (frame.time_s != poses[index].time_s) return "differs in time from the trajectory";
  if (frame.keyframe.value >= static_cast<int>(poses.size()))
    return "names a keyframe that does not exist";
  return {};
}

Status CheckFrames(const FramesFile& file,
                   std::span<const StampedPose> poses,
                   std::string_view name) {
  if (file.frames.size() != poses.size()) {
    return InvalidInput(fmt::format("{}: frames has {} entries, the trajectory has {} poses",
                                    name,
                                    file.frames.size(),
                                    poses.size()));
  }
  for (std::size_t n = 0; n < poses.size(); ++n) {
    if (const std::string fault = FaultOf(file.frames[n], n, poses); !fault.empty())
      return InvalidInput(fmt::format("{}: frames[{}] {}", name, n, fault));
  }
  FrameIdx last;
  for (std::size_t n = 0; n < file.keyframes.size(); ++n) {
    const FrameIdx keyframe = file.keyframes[n];
    if (keyframe <= last || keyframe.value >= static_cast<int>(poses.size())) {
      return InvalidInput(fmt::format("{}: keyframes[{}] is {}, must be a frame behind {}",
                                      name,
                                      n,
                                      keyframe.value,
                                      last.value));
    }
    last = keyframe;
  }
  return Ok();
}

// frames.json with the poses of the TUM text.
Result<FramesFile> DecodeFrames(TextSource frames_json,
                                TextSource tum_text,
                                std::string_view name) {
  const Result<std::vector<StampedPose>> poses = DecodeTum(std::move(tum_text), name);
  if (!poses.ok()) return poses.error();
  Result<FramesFile> file = DecodeDocument<FramesFile>(kFormat, std::move(frames_json), name);
  if (!file.ok()) return file.error();
  if (Status status = CheckFrames(*file, *poses, name); !status.ok()) return status.error();
  for (std::size_t n = 0; n < poses->size(); ++n)
    file->frames[n].world_from_camera = (*poses)[n].world_from_camera;
  return file;
}

}  // namespace

Result<std::string> EncodeTum(std::span<const StampedPose> poses, std::string_view name) {
  std::string text = "# time_s tx ty tz qx qy qz qw (world from camera)\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d& t = poses[i].world_from_camera.translation_m;
    const Eigen::Vector4d q = poses[i].world_from_camera.rotation.coeffs();
    if (!t.allFinite() || !q.allFinite() || !std::isfinite(poses[i].time_s)) {
      return Failed(fmt::format("{}: pose {} is not finite", name, i));
    }
    text += ShortestDecimal(poses[i].time_s);
    for (const double value : {t[0], t[1], t[2], q[0], q[1], q[2], q[3]}) {
      text += ' ';
      text += ShortestDecimal(value);
    }
    text += '\n';
  }
  return text;
}

Result<std::vector<StampedPose>> DecodeTum(TextSource text, std::string_view name) {
  std::vector<StampedPose> poses;
  const auto decode = [&](std::string_view line) -> Status {
    const std::vector<std::string_view> words = Words(line);
    if (words.empty() || words.front().front() == '#') return Ok();
    const Result<StampedPose> pose = DecodeTumLine(words);
    if (!pose.ok()) return pose.error();
    poses.push_back(*pose);
    return Ok();
  };
  if (Status status = ForLines(std::move(text), name, decode); !status.ok()) return status.error();
  return poses;
}

std::vector<StampedPose> StampedPoses(std::span<const TrackedFrame> frames) {
  std::vector<StampedPose> poses;
  for (const TrackedFrame& frame : frames) poses.push_back({frame.time_s, frame.world_from_camera});
  return poses;
}

std::vector<StampedPose> KeyframePoses(std::span<const TrackedFrame> frames,
                                       std::span<const FrameIdx> keyframes) {
  std::vector<StampedPose> poses;
  for (const FrameIdx keyframe : keyframes) {
    const TrackedFrame& frame = frames[static_cast<std::size_t>(keyframe.value)];
    poses.push_back({frame.time_s, frame.world_from_camera});
  }
  return poses;
}

Result<std::string> EncodeFrames(std::span<const TrackedFrame> frames,
                                 std::span<const FrameIdx> keyframes,
                                 std::span<const KeyframeJoin> joins,
                                 std::string_view name) {
  FramesFile file{{frames.begin(), frames.end()}, {keyframes.begin(), keyframes.end()}, {}};
  for (const KeyframeJoin& join : joins) {
    if (join.composed) file.composed_edges.push_back({join.i, join.j});
  }
  return EncodeDocument(kFormat, file, name);
}

Result<Trajectory> DecodeTrajectory(TextSource frames_json,
                                    TextSource tum_text,
                                    std::string_view name) {
  Result<FramesFile> file = DecodeFrames(std::move(frames_json), std::move(tum_text), name);
  if (!file.ok()) return file.error();
  return Trajectory{std::move(file->frames), std::move(file->keyframes)};
}

Result<Trajectory> DecodeOdometry(OdometryTexts texts, const EdgeSink& take) {
  Result<FramesFile> file =
      DecodeFrames(std::move(texts.frames_json), std::move(texts.tum), texts.name);
  if (!file.ok()) return file.error();
  const int num_frames = static_cast<int>(file->frames.size());
  std::set<std::pair<FrameIdx, FrameIdx>> composed;
  for (const ComposedEdge& edge : file->composed_edges) composed.emplace(edge.i, edge.j);
  const auto take_flagged = [&](RelativePose edge) -> Status {
    if (edge.i.value >= num_frames || edge.j.value >= num_frames) {
      return InvalidInput(fmt::format("joins frames {} and {} of the {} of {}",
                                      edge.i.value,
                                      edge.j.value,
                                      num_frames,
                                      texts.name));
    }
    edge.composed = composed.contains({edge.i, edge.j});
    return take(edge);
  };
  if (Status status = DecodeG2oEdges(std::move(texts.g2o), texts.g2o_name, take_flagged);
      !status.ok())
    return status.error();
  return Trajectory{std::move(file->frames), std::move(file->keyframes)};
}

}  // namespace deepslam::artifact
