#include "deepslam/artifact/segments_json.h"

#include <utility>
#include <vector>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/segments", 1};
constexpr std::string_view kSegmentsKey = "segments";

namespace {

void DescribeWithoutMask(JsonVisitor& visitor, Segment& segment) {
  visitor.Field("detection", segment.detection);
  visitor.Field("frame", segment.frame);
  visitor.Field("class", segment.class_name);
  visitor.Field("score", segment.score, kShare);
  visitor.Maybe("source", segment.source);
  visitor.Field("bbox", segment.box_px);
  visitor.Field("num_points", segment.num_points);
  visitor.Maybe("extent_camera_m", segment.extent_camera);
  visitor.Field("depth_support", segment.depth_support);
  visitor.Field("touches_border", segment.touches_border);
  visitor.Field("usable", segment.usable);
  visitor.Field("reason", segment.reason);
}

}  // namespace

void Describe(JsonVisitor& visitor, Segment& segment) {
  DescribeWithoutMask(visitor, segment);
  visitor.Maybe("segmentation", segment.mask);
}

namespace {

// Of the rows, what `take` makes of them.
Result<std::vector<Segment>> DecodeRows(
    TextSource text,
    std::string_view name,
    const std::function<void(const JsonNode& row, std::vector<Segment>& segments)>& take) {
  std::vector<Segment> segments;
  const auto read = [&](std::span<const JsonNode> rows) {
    for (const JsonNode& row : rows) take(row, segments);
  };
  const JsonReader reader(
      std::move(text), name, kFormat.name, kFormat.version, {{kSegmentsKey, read}});
  return reader.Finish(std::move(segments));
}

}  // namespace

Status EncodeSegments(std::span<const Segment> segments,
                      std::string_view name,
                      const TextSink& sink) {
  JsonObject document = NewDocument(kFormat.name, kFormat.version);
  document.emplace(kSegmentsKey,
                   RowsOf(segments, [](const Segment& segment) { return ToJson(segment); }));
  return DumpJson(std::move(document), name, sink);
}

Result<std::vector<Segment>> DecodeSegments(TextSource text, std::string_view name) {
  return DecodeRows(std::move(text), name, [](const JsonNode& row, std::vector<Segment>& segments) {
    segments.push_back(FromJson<Segment>(row));
  });
}

Status DecodeEachSegment(TextSource text,
                         std::string_view name,
                         const std::function<Status(Segment segment)>& take) {
  Status taken = Ok();
  const auto decoded =
      DecodeRows(std::move(text), name, [&](const JsonNode& row, std::vector<Segment>&) {
        if (taken.ok()) taken = take(FromJson<Segment>(row));
      });
  return decoded.ok() ? taken : Status(decoded.error());
}

Result<std::vector<Segment>> DecodeSegmentsWithoutMasks(TextSource text, std::string_view name) {
  return DecodeRows(std::move(text), name, [](const JsonNode& row, std::vector<Segment>& segments) {
    JsonVisitor visitor(row);
    DescribeWithoutMask(visitor, segments.emplace_back());
  });
}

Result<std::vector<Segment>> DecodeSegmentsOf(const std::set<DetectionId>& wanted,
                                              TextSource text,
                                              std::string_view name) {
  return DecodeRows(
      std::move(text), name, [&](const JsonNode& row, std::vector<Segment>& segments) {
        if (!wanted.contains(FromJson<DetectionId>(row["detection"]))) return;
        segments.push_back(FromJson<Segment>(row));
      });
}

}  // namespace deepslam::artifact
