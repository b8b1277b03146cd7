#include "deepslam/artifact/segments_json.h"

#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/segments";
constexpr int kVersion = 1;

}  // namespace

Result<std::string> EncodeSegments(std::span<const Segment> segments, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  std::vector<const PixelMask*> masks;
  for (const Segment& segment : segments) masks.push_back(&segment.mask);
  std::vector<JsonValue> segmentations = MasksToJson(masks);
  JsonArray rows;
  for (const Segment& segment : segments) {
    JsonObject row;
    row.emplace("detection", ToJson(segment.detection));
    row.emplace("frame", ToJson(segment.frame));
    row.emplace("class", segment.class_name);
    row.emplace("score", segment.score);
    row.emplace("source", NameOf(segment.source));
    row.emplace("bbox", ToCocoBox(segment.box_px));
    row.emplace("segmentation", std::move(segmentations[rows.size()]));
    row.emplace("num_points", segment.num_points);
    row.emplace("extent_camera_m", ToJson(segment.extent_camera));
    row.emplace("depth_support", segment.depth_support);
    row.emplace("touches_border", segment.touches_border);
    row.emplace("usable", segment.usable);
    row.emplace("reason", segment.reason);
    rows.emplace_back(std::move(row));
  }
  document.emplace("segments", std::move(rows));
  return DumpJson(std::move(document), name);
}

Result<std::vector<Segment>> DecodeSegments(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kFormat, kVersion);
  std::vector<Segment> segments;
  std::vector<JsonNode> segmentations;
  for (const JsonNode& row : reader.root()["segments"].Items()) {
    Segment segment;
    segment.detection = ReadId<DetectionId>(row["detection"]);
    segment.frame = ReadId<FrameIdx>(row["frame"]);
    segment.class_name = row["class"].String();
    segment.score = row["score"].Number(0, 1);
    if (const JsonNode source = row.Maybe("source"); source.is_string())
      segment.source = ReadDetectionSource(source);
    segment.box_px = ReadCocoBox(row["bbox"]);
    segmentations.push_back(row.Maybe("segmentation"));
    segment.num_points = row["num_points"].Int(0, kMaxId);
    segment.extent_camera = ReadBox3(row.Maybe("extent_camera_m"));
    segment.depth_support = row["depth_support"].Number();
    segment.touches_border = row["touches_border"].Bool();
    segment.usable = row["usable"].Bool();
    segment.reason = row["reason"].String();
    segments.push_back(std::move(segment));
  }
  std::vector<PixelMask> masks = ReadMasks(segmentations);
  for (std::size_t i = 0; i < masks.size(); ++i) segments[i].mask = std::move(masks[i]);
  return reader.Finish(std::move(segments));
}

}  // namespace deepslam::artifact
