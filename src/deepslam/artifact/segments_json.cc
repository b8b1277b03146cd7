#include "deepslam/artifact/segments_json.h"

#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/segments";
constexpr int kVersion = 1;

JsonValue SegmentToJson(const Segment& segment) {
  JsonObject row;
  row.emplace("detection", ToJson(segment.detection));
  row.emplace("frame", ToJson(segment.frame));
  row.emplace("class", segment.class_name);
  row.emplace("score", segment.score);
  row.emplace("source", NameOf(segment.source));
  row.emplace("bbox", ToCocoBox(segment.box_px));
  row.emplace("segmentation", ToJson(segment.mask));
  row.emplace("num_points", segment.num_points);
  row.emplace("extent_camera_m", ToJson(segment.extent_camera));
  row.emplace("depth_support", segment.depth_support);
  row.emplace("touches_border", segment.touches_border);
  row.emplace("usable", segment.usable);
  row.emplace("reason", segment.reason);
  return JsonValue(std::move(row));
}

// All but its mask.
Segment ReadSegment(const JsonNode& row) {
  Segment segment;
  segment.detection = ReadId<DetectionId>(row["detection"]);
  segment.frame = ReadId<FrameIdx>(row["frame"]);
  segment.class_name = row["class"].String();
  segment.score = row["score"].Number(0, 1);
  if (const JsonNode source = row.Maybe("source"); source.is_string())
    segment.source = ReadDetectionSource(source);
  segment.box_px = ReadCocoBox(row["bbox"]);
  segment.num_points = row["num_points"].Int(0, kMaxId);
  segment.extent_camera = ReadBox3(row.Maybe("extent_camera_m"));
  segment.depth_support = row["depth_support"].Number();
  segment.touches_border = row["touches_border"].Bool();
  segment.usable = row["usable"].Bool();
  segment.reason = row["reason"].String();
  return segment;
}

Segment ReadSegmentWithMask(const JsonNode& row) {
  Segment segment = ReadSegment(row);
  segment.mask = ReadMask(row.Maybe("segmentation"));
  return segment;
}

// Of the rows, what `take` makes of them.
Result<std::vector<Segment>> DecodeRows(
    TextSource text,
    std::string_view name,
    const std::function<void(const JsonNode& row, std::vector<Segment>& segments)>& take) {
  std::vector<Segment> segments;
  const auto read = [&](std::span<const JsonNode> rows) {
    for (const JsonNode& row : rows) take(row, segments);
  };
  const JsonReader reader(std::move(text), name, kFormat, kVersion, {{"segments", read}});
  return reader.Finish(std::move(segments));
}

}  // namespace

Status EncodeSegments(std::span<const Segment> segments,
                      std::string_view name,
                      const TextSink& sink) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("segments", RowsOf(segments, SegmentToJson));
  return DumpJson(std::move(document), name, sink);
}

Result<std::vector<Segment>> DecodeSegments(TextSource text, std::string_view name) {
  return DecodeRows(std::move(text), name, [](const JsonNode& row, std::vector<Segment>& segments) {
    segments.push_back(ReadSegmentWithMask(row));
  });
}

Status DecodeEachSegment(TextSource text,
                         std::string_view name,
                         const std::function<Status(Segment segment)>& take) {
  Status taken = Ok();
  const auto decoded =
      DecodeRows(std::move(text), name, [&](const JsonNode& row, std::vector<Segment>&) {
        if (taken.ok()) taken = take(ReadSegmentWithMask(row));
      });
  return decoded.ok() ? taken : Status(decoded.error());
}

Result<std::vector<Segment>> DecodeSegmentsWithoutMasks(TextSource text, std::string_view name) {
  return DecodeRows(std::move(text), name, [](const JsonNode& row, std::vector<Segment>& segments) {
    segments.push_back(ReadSegment(row));
  });
}

Result<std::vector<Segment>> DecodeSegmentsOf(const std::set<DetectionId>& wanted,
                                              TextSource text,
                                              std::string_view name) {
  return DecodeRows(
      std::move(text), name, [&](const JsonNode& row, std::vector<Segment>& segments) {
        if (!wanted.contains(ReadId<DetectionId>(row["detection"]))) return;
        segments.push_back(ReadSegmentWithMask(row));
      });
}

}  // namespace deepslam::artifact
