#include "deepslam/artifact/trajectory_files.h"

#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"
#include "deepslam/artifact/text_numbers.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/frames";
constexpr int kVersion = 1;
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

JsonValue FrameToJson(const TrackedFrame& frame) {
  JsonObject row;
  row.emplace("frame", ToJson(frame.frame));
  row.emplace("time_s", frame.time_s);
  row.emplace("status", NameOf(frame.status));
  row.emplace("keyframe", ToJson(frame.keyframe));
  row.emplace("rmse_m", frame.rmse_m);
  row.emplace("inlier_share", frame.inlier_share);
  return JsonValue(std::move(row));
}

// Entry `index` of as many as there are poses.
TrackedFrame ReadFrame(const JsonNode& row, std::size_t index, std::span<const StampedPose> poses) {
  TrackedFrame frame;
  frame.frame = ReadId<FrameIdx>(row["frame"]);
  frame.time_s = row["time_s"].Number();
  frame.world_from_camera = poses[index].world_from_camera;
  frame.status = ReadTrackingStatus(row["status"]);
  frame.keyframe = ReadId<FrameIdx>(row.Maybe("keyframe"));
  frame.rmse_m = row["rmse_m"].Number();
  frame.inlier_share = row["inlier_share"].Number();
  // Frames are addressed by their index all over the program.
  if (frame.frame.value != static_cast<int>(index))
    row.Fail(fmt::format("is frame {}, must be {}", frame.frame.value, index));
  if (frame.time_s != poses[index].time_s) row.Fail("differs in time from the trajectory");
  if (frame.keyframe.value >= static_cast<int>(poses.size()))
    row.Fail("names a keyframe that does not exist");
  return frame;
}

struct FramesFile {
  Trajectory trajectory;
  std::set<std::pair<FrameIdx, FrameIdx>> composed;  // edges
};

Result<FramesFile> DecodeFrames(TextSource frames_json,
                                TextSource tum_text,
                                std::string_view name) {
  const Result<std::vector<StampedPose>> poses = DecodeTum(std::move(tum_text), name);
  if (!poses.ok()) return poses.error();
  FramesFile file;
  std::vector<TrackedFrame>& frames = file.trajectory.frames;
  std::size_t num_rows = 0;
  const auto read = [&](std::span<const JsonNode> rows) {
    for (const JsonNode& row : rows) {
      if (num_rows < poses->size()) frames.push_back(ReadFrame(row, num_rows, *poses));
      ++num_rows;
    }
  };
  JsonReader reader(std::move(frames_json), name, kFormat, kVersion, {{"frames", read}});
  if (num_rows != poses->size()) {
    reader.Fail(
        "frames",
        fmt::format("has {} entries, the trajectory has {} poses", num_rows, poses->size()));
  }
  FrameIdx last;
  for (const JsonNode& node : reader.root()["keyframes"].Items()) {
    const FrameIdx keyframe{node.Int(0, std::max(0, static_cast<int>(num_rows) - 1))};
    if (keyframe <= last) node.Fail("is not ascending");
    last = keyframe;
    file.trajectory.keyframes.push_back(keyframe);
  }
  for (const JsonNode& node : reader.root()["composed_edges"].Items()) {
    const std::vector<JsonNode> pair = node.Items(2);
    file.composed.emplace(ReadId<FrameIdx>(pair[0]), ReadId<FrameIdx>(pair[1]));
  }
  return reader.Finish(std::move(file));
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
  JsonObject document = NewDocument(kFormat, kVersion);
  JsonArray keyframe_list;
  for (const FrameIdx keyframe : keyframes) keyframe_list.push_back(ToJson(keyframe));
  JsonArray composed;
  for (const KeyframeJoin& join : joins) {
    if (join.composed) composed.emplace_back(JsonArray{ToJson(join.i), ToJson(join.j)});
  }
  document.emplace("frames", RowsOf(frames, FrameToJson));
  document.emplace("keyframes", std::move(keyframe_list));
  document.emplace("composed_edges", std::move(composed));
  return DumpJson(std::move(document), name);
}

Result<Trajectory> DecodeTrajectory(TextSource frames_json,
                                    TextSource tum_text,
                                    std::string_view name) {
  Result<FramesFile> file = DecodeFrames(std::move(frames_json), std::move(tum_text), name);
  if (!file.ok()) return file.error();
  return std::move(file->trajectory);
}

Result<Trajectory> DecodeOdometry(OdometryTexts texts, const EdgeSink& take) {
  Result<FramesFile> file =
      DecodeFrames(std::move(texts.frames_json), std::move(texts.tum), texts.name);
  if (!file.ok()) return file.error();
  const int num_frames = static_cast<int>(file->trajectory.frames.size());
  const auto take_flagged = [&](RelativePose edge) -> Status {
    if (edge.i.value >= num_frames || edge.j.value >= num_frames) {
      return InvalidInput(fmt::format("joins frames {} and {} of the {} of {}",
                                      edge.i.value,
                                      edge.j.value,
                                      num_frames,
                                      texts.name));
    }
    edge.composed = file->composed.contains({edge.i, edge.j});
    return take(edge);
  };
  if (Status status = DecodeG2oEdges(std::move(texts.g2o), texts.g2o_name, take_flagged);
      !status.ok())
    return status.error();
  return std::move(file->trajectory);
}

}  // namespace deepslam::artifact
