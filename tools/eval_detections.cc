// `deepslam eval detections`: boxes of stage `detect` against the true instance masks.
#include <algorithm>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "deepslam/artifact/detections_json.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/eval/detection_match.h"
#include "deepslam/storage/store.h"
#include "eval_commands.h"
#include "eval_data.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

struct Counts {
  int num_seen = 0;       // true boxes, over all frames
  int num_found = 0;      // with a detection of their class
  int num_found_any = 0;  // with a detection of whatever class
  int num_detected = 0;
  int num_by_network = 0;  // of those found, by the network (the rest by depth clusters or a file)

  [[nodiscard]] double recall() const {
    return num_seen > 0 ? static_cast<double>(num_found) / num_seen : 1.0;
  }
  [[nodiscard]] double precision() const {
    return num_detected > 0 ? static_cast<double>(num_found) / num_detected : 1.0;
  }
};

struct Tally {
  std::map<std::string, Counts> classes;
  std::vector<Counts> objects;  // by number in the masks
  int num_frames = 0;
};

void AddCounts(const Counts& counts, JsonObject& row) {
  row.emplace("num_seen", counts.num_seen);
  row.emplace("num_found", counts.num_found);
  row.emplace("num_found_any_class", counts.num_found_any);
  row.emplace("num_found_by_network", counts.num_by_network);
  row.emplace("num_detected", counts.num_detected);
  row.emplace("recall", counts.recall());
  row.emplace("precision", counts.precision());
}

Result<artifact::DetectionTable> ReadDetections(const fs::path& workspace) {
  const fs::path file = workspace / "detect" / "detections.json";
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  return artifact::DecodeDetections(*text, file.string());
}

Status ScoreFrame(const artifact::DetectedImage& image,
                  const artifact::DetectionTable& table,
                  const Truth& truth,
                  Tally& tally) {
  const fs::path file =
      truth.capture / "truth" / "instances" / fmt::format("{:06d}.png", image.frame.value);
  const auto instances = dataset::ReadDepthFile(file, image.width, image.height);
  if (!instances.ok()) return InvalidInput("instance mask " + instances.error().message);
  const auto count = static_cast<int>(tally.objects.size());
  const int min_pixels = static_cast<int>(kVisibleShare * image.width * image.height);
  const std::vector<Box2> boxes = eval::VisibleBoxes(*instances, count, min_pixels);
  std::vector<eval::ImageBox> seen;
  std::vector<std::size_t> numbers;
  for (const TrueObject& object : truth.objects) {
    const auto n = static_cast<std::size_t>(object.number - 1);
    if (boxes[n].empty()) continue;
    seen.push_back({object.box.class_name, boxes[n]});
    numbers.push_back(n);
    ++tally.objects[n].num_seen;
    ++tally.classes[object.box.class_name].num_seen;
  }
  std::vector<eval::ImageBox> detected;
  std::vector<bool> by_network;
  for (const Detection& detection : table.detections) {
    if (detection.frame != image.frame) continue;
    detected.push_back({detection.class_name, detection.box_px});
    by_network.push_back(detection.source == DetectionSource::kNetwork);
    ++tally.classes[detection.class_name].num_detected;
  }
  for (const eval::BoxMatch& match : eval::MatchBoxes(detected, seen, eval::kDetectionIou)) {
    for (Counts* counts :
         {&tally.classes[seen[match.truth].class_name], &tally.objects[numbers[match.truth]]}) {
      ++counts->num_found_any;
      if (!match.same_class) continue;
      ++counts->num_found;
      if (by_network[match.detected]) ++counts->num_by_network;
    }
  }
  ++tally.num_frames;
  return Ok();
}

JsonArray ClassRows(const Tally& tally) {
  fmt::print(stderr,
             "{:<12} {:>6} {:>7} {:>10} {:>9} {:>8} {:>9}\n",
             "class",
             "seen",
             "found",
             "any class",
             "detected",
             "recall",
             "precision");
  JsonArray rows;
  for (const auto& [class_name, counts] : tally.classes) {
    fmt::print(stderr,
               "{:<12} {:>6} {:>7} {:>10} {:>9} {:>8.3f} {:>9.3f}\n",
               class_name,
               counts.num_seen,
               counts.num_found,
               counts.num_found_any,
               counts.num_detected,
               counts.recall(),
               counts.precision());
    JsonObject row;
    row.emplace("class", class_name);
    AddCounts(counts, row);
    rows.emplace_back(std::move(row));
  }
  return rows;
}

Status EvalDetections(const fs::path& workspace,
                      const fs::path& capture,
                      const std::string& json_file) {
  const Result<Truth> truth = ReadTruth(capture, "");
  if (!truth.ok()) return truth.error();
  const Result<artifact::DetectionTable> table = ReadDetections(workspace);
  if (!table.ok()) return table.error();
  Tally tally;
  int most = 0;
  for (const TrueObject& object : truth->objects) most = std::max(most, object.number);
  tally.objects.resize(static_cast<std::size_t>(most));
  for (const artifact::DetectedImage& image : table->images) {
    if (Status status = ScoreFrame(image, *table, *truth, tally); !status.ok()) return status;
  }
  JsonObject document = artifact::NewDocument("deepslam/eval_detections", 1);
  document.emplace("protocol", eval::kDetectionProtocol);
  document.emplace("classes", ClassRows(tally));
  Counts all;
  for (const auto& [class_name, counts] : tally.classes) {
    all.num_seen += counts.num_seen;
    all.num_found += counts.num_found;
    all.num_found_any += counts.num_found_any;
    all.num_by_network += counts.num_by_network;
    all.num_detected += counts.num_detected;
  }
  JsonArray objects;
  int num_objects_found = 0;
  for (const TrueObject& object : truth->objects) {
    const Counts& counts = tally.objects[static_cast<std::size_t>(object.number - 1)];
    num_objects_found += counts.num_found > 0 ? 1 : 0;
    JsonObject row;
    row.emplace("number", object.number);
    row.emplace("class", object.box.class_name);
    row.emplace("num_seen", counts.num_seen);
    row.emplace("num_found", counts.num_found);
    row.emplace("num_found_any_class", counts.num_found_any);
    objects.emplace_back(std::move(row));
  }
  document.emplace("objects", std::move(objects));
  JsonObject summary;
  AddCounts(all, summary);
  summary.emplace("num_frames", tally.num_frames);
  summary.emplace("num_objects", static_cast<int>(truth->objects.size()));
  summary.emplace("num_objects_found", num_objects_found);
  document.emplace("summary", std::move(summary));
  fmt::print(stderr,
             "recall {:.3f} ({:.3f} whatever the class) of {} boxes in {} frames; {} of {} objects "
             "found at least once\n",
             all.recall(),
             all.num_seen > 0 ? static_cast<double>(all.num_found_any) / all.num_seen : 1.0,
             all.num_seen,
             tally.num_frames,
             num_objects_found,
             truth->objects.size());
  const Result<std::string> text = DumpJson(std::move(document), "detections");
  return text.ok() ? WriteResult(json_file, *text) : Status(text.error());
}

}  // namespace

void AddEvalDetections(CLI::App& eval_command, Command& chosen) {
  struct Arguments {
    std::string workspace;
    std::string capture;
    std::string json;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = eval_command.add_subcommand(
      "detections", "Boxes of stage detect against the instance masks of a rendered capture");
  command->add_option("WORKSPACE", arguments->workspace, "Workspace of a run")->required();
  command->add_option("TRUTH", arguments->capture, "The capture, with truth/instances")->required();
  command->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  command->callback([&chosen, arguments] {
    chosen = [arguments] {
      const Status status =
          EvalDetections(arguments->workspace, arguments->capture, arguments->json);
      return status.ok() ? kExitOk : ReportError(status.error());
    };
  });
}

}  // namespace deepslam::tools
