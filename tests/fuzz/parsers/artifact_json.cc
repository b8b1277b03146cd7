// The other artifacts in JSON: the text's own `format` says which reader it is for.
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/detections_json.h"
#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/summary_json.h"
#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/batch/capture_record.h"
#include "deepslam/pipeline/manifest.h"
#include "fuzz/entry.h"
#include "support/text_in_pieces.h"

namespace deepslam::fuzz {
namespace {

using Reader = std::function<bool(std::string_view)>;

template <typename Decode, typename Encode>
Reader Of(Decode decode, Encode encode) {
  return [=](std::string_view bytes) { return RoundTrip(bytes, decode, encode); };
}

Result<std::string> SegmentsText(const std::vector<Segment>& segments, std::string_view name) {
  return WholeText(
      [&](const TextSink& sink) { return artifact::EncodeSegments(segments, name, sink); });
}

const std::map<std::string, Reader, std::less<>>& Readers() {
  static const std::map<std::string, Reader, std::less<>> readers = {
      {"deepslam/tracks", Of(artifact::DecodeAssociation, artifact::EncodeAssociation)},
      {"deepslam/detections", Of(artifact::DecodeDetections, artifact::EncodeDetections)},
      {"deepslam/doubts", Of(artifact::DecodeDoubts, artifact::EncodeDoubts)},
      {"deepslam/ground", Of(artifact::DecodeGround, artifact::EncodeGround)},
      {"deepslam/loops", Of(artifact::DecodeLoops, artifact::EncodeLoops)},
      {"deepslam/objects", Of(artifact::DecodeObjectMap, artifact::EncodeObjectMap)},
      {"deepslam/candidates", Of(artifact::DecodeProposals, artifact::EncodeProposals)},
      {"deepslam/segments", Of(artifact::DecodeSegments, SegmentsText)},
      {"deepslam/registrations", Of(artifact::DecodeRegistrations, artifact::EncodeRegistrations)},
      {"deepslam/optimization", Of(artifact::DecodeOptimization, artifact::EncodeOptimization)},
      {"deepslam/overrides", Of(artifact::DecodeApplied, artifact::EncodeApplied)},
      {"deepslam/manifest", Of(pipeline::DecodeManifest, pipeline::EncodeManifest)},
      {"deepslam/timing", Of(pipeline::DecodeTiming, pipeline::EncodeTiming)},
      {"deepslam/batch", Of(batch::DecodeBatch, batch::EncodeBatch)},
      {"deepslam/batch_record", Of(batch::DecodeRecord, batch::EncodeRecord)},
      {"deepslam/batch_plan", Of(batch::DecodePlan, batch::EncodePlan)},
  };
  return readers;
}

}  // namespace
}  // namespace deepslam::fuzz

DEEPSLAM_FUZZ(artifact_json) {
  const Result<artifact::JsonValue> document = artifact::ParseJson(bytes, kFile);
  const Result<artifact::JsonValue> by_pieces =
      artifact::ParseJson(testing_support::InPieces(bytes, 1 + bytes.size() % 7), kFile);
  DEEPSLAM_CHECK(by_pieces.ok() == document.ok(), "pieces are read as the whole");
  if (!document.ok()) {
    DEEPSLAM_CHECK(by_pieces.error().message == document.error().message, "and refused as it is");
    return Refused(document.error());
  }
  const Result<std::string> text = artifact::DumpJson(*document, kFile);
  DEEPSLAM_CHECK(text.ok(), "JSON that was read can be written");
  DEEPSLAM_CHECK(*text == *artifact::DumpJson(*by_pieces, kFile), "pieces are read as the whole");
  const auto* object = document->As<artifact::JsonObject>();
  if (object == nullptr) return false;
  const auto format = object->find("format");
  const auto* name = format == object->end() ? nullptr : format->second.As<std::string>();
  if (name == nullptr) return false;
  const auto reader = Readers().find(*name);
  return reader != Readers().end() && reader->second(bytes);
}
