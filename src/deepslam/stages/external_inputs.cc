#include "deepslam/stages/external_inputs.h"

#include <filesystem>
#include <string_view>

#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/core/sha256.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/data_folder.h"

namespace deepslam::stages {
namespace {

using StringMap = std::map<std::string, std::string>;

// What lies at a place enters a key by its content.
Status AddContent(const RunInputs& inputs,
                  const std::string& key,
                  const Result<std::filesystem::path>& place,
                  StringMap& hashes) {
  if (!place.ok()) return place.error();
  const Result<std::string> hash =
      inputs.hashes ? inputs.hashes->Of(*place) : ContentHashes().Of(*place);
  if (!hash.ok()) return hash.error();
  hashes.emplace(key, *hash);
  return Ok();
}

Status AddDetector(const RunInputs& inputs, StringMap& hashes) {
  const DetectStageOptions& options = inputs.config.detect_stage;
  if (options.source == "none") return Ok();
  if (options.source == "network") {
    const Result<std::filesystem::path> file = FindWeights(inputs.data_folder, options.weights);
    return AddContent(inputs, "weights", file, hashes);
  }
  if (options.file.empty())
    return InvalidConfig("detect.source is file, but detect.file names none");
  return AddContent(inputs, "coco_file", std::filesystem::path(options.file), hashes);
}

Status AddLibrary(const RunInputs& inputs, StringMap& hashes) {
  const ProposeStageOptions& options = inputs.config.propose_stage;
  if (!options.retrieval) return Ok();
  const Result<std::filesystem::path> folder = FindLibrary(inputs.data_folder, options.library);
  return AddContent(inputs, "library", folder, hashes);
}

Status AddPriors(const RunInputs& inputs, StringMap& hashes) {
  const ProposeStageOptions& options = inputs.config.propose_stage;
  if (!options.network) return Ok();
  const auto folder = FindPriors(inputs.data_folder, options.priors);
  if (!folder.ok()) return folder.error();
  if (!*folder) return Ok();
  return AddContent(inputs, "priors", **folder, hashes);
}

// Who changes a density makes no detection anew.
ClassTable WithoutExportColumns(ClassTable table) {
  for (ObjectClass& c : table.classes) {
    c.labels_elsewhere = {};
    c.physics = {};
  }
  return table;
}

}  // namespace

Result<std::map<std::string, std::string>> HashExternals(const RunInputs& inputs, unsigned what) {
  StringMap hashes;
  if ((what & kFrames) != 0 && inputs.capture)
    hashes.emplace("capture", inputs.capture->content_hash);
  if ((what & kClasses) != 0) {
    const bool all = (what & kExportColumns) != 0;
    hashes.emplace("classes",
                   Sha256Hex(class_table::EncodeClassTable(
                       all ? inputs.classes : WithoutExportColumns(inputs.classes))));
  }
  if ((what & kDetector) != 0) {
    if (Status status = AddDetector(inputs, hashes); !status.ok()) return status.error();
  }
  if ((what & kLibrary) != 0) {
    if (Status status = AddLibrary(inputs, hashes); !status.ok()) return status.error();
  }
  if ((what & kPriors) != 0) {
    if (Status status = AddPriors(inputs, hashes); !status.ok()) return status.error();
  }
  // What is not overridden leaves no trace: an empty file is as good as none.
  const auto add = [&](unsigned part, std::string_view name, const std::string& text) {
    if ((what & part) != 0 && !text.empty()) hashes.emplace(name, Sha256Hex(text));
  };
  add(kGroundHint, kOverrideInputs[0], artifact::GroundOverridesText(inputs.overrides));
  add(kTrackOverrides, kOverrideInputs[1], artifact::TrackOverridesText(inputs.overrides));
  add(kChoices, kOverrideInputs[2], artifact::ChoiceOverridesText(inputs.overrides));
  return hashes;
}

void HashModels(const RunInputs& inputs) {
  for (const unsigned what : {kDetector, kLibrary, kPriors})
    static_cast<void>(HashExternals(inputs, what));
}

}  // namespace deepslam::stages
