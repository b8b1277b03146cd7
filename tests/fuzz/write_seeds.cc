// Writes the seeds of the corpora that come out of the program's own writers, seed_* in each
// parser's folder. Texts that people write are in the corpora by hand.
//   deepslam_fuzz_seeds tests/fuzz/corpus
#include <filesystem>
#include <iostream>
#include <string>

#include "artifact/sample_values.h"
#include "deepslam/artifact/association_json.h"
#include "deepslam/artifact/ground_json.h"
#include "deepslam/artifact/loops_json.h"
#include "deepslam/artifact/objects_json.h"
#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/proposals_json.h"
#include "deepslam/artifact/registrations_json.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/batch/batch_plan.h"
#include "deepslam/batch/batch_state.h"
#include "deepslam/frames/run_lengths.h"
#include "deepslam/gltf/draco_encode.h"
#include "deepslam/pipeline/manifest.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/voxel_code.h"
#include "gltf/test_scene.h"
#include "layouts/foreign_captures.h"
#include "support/grid_onnx.h"
#include "support/temp_dir.h"
#include "support/tiny_onnx.h"

namespace deepslam {
namespace {

using testing_support::TinyNetwork;
using testing_support::WriteOnnx;

class Corpus {
 public:
  explicit Corpus(std::filesystem::path folder) : folder_(std::move(folder)) {}
  void Put(const std::string& parser, const std::string& name, const std::string& bytes) {
    testing_support::WriteText(folder_ / parser / ("seed_" + name), bytes);
  }

 private:
  std::filesystem::path folder_;
};

void PutArtifacts(Corpus& corpus) {
  using namespace artifact;         // NOLINT(google-build-using-namespace)
  using namespace testing_support;  // NOLINT(google-build-using-namespace)
  const auto json = [&](const char* name, const Result<std::string>& text) {
    corpus.Put("artifact_json", name, text.value());
  };
  json("doubts", EncodeDoubts({"few fit"}, "f"));
  json("ground", EncodeGround(SampleGround(), "f"));
  json("detections", EncodeDetections(SampleDetections(), "f"));
  json("tracks", EncodeAssociation(SampleAssociation(), "f"));
  json("candidates", EncodeProposals(SampleProposals(), "f"));
  json("objects", EncodeObjectMap(SampleObjects(), "f"));
  json("loops", EncodeLoops(SampleLoops(), "f"));
  json("optimization", EncodeOptimization(SampleOptimization(), "f"));
  json("segments", SegmentsText(SampleSegments()));
  json("registrations", EncodeRegistrations(SampleRegistrations(), "f"));
  json("overrides", EncodeApplied({"drop 4"}, "f"));
  pipeline::Manifest manifest;
  manifest.stage = "track";
  manifest.stage_version = 3;
  manifest.options = {{"track.max_depth_m", "4"}};
  manifest.inputs = {{"capture", "ab"}};
  manifest.external_inputs = {{"weights", "cd"}};
  manifest.outputs = {{"frames.json", {"ef", 12}}};
  manifest.summary = {"5 frames", {{"frames", 5}}};
  json("manifest", pipeline::EncodeManifest(manifest, "f"));
  json("timing", pipeline::EncodeTiming({1.5, 2.5, 300}, "f"));
  batch::CaptureRecord record;
  record.name = "kitchen";
  record.capture = "/data/kitchen";
  record.state = batch::CaptureState::kDone;
  record.attempts = 2;
  record.stage_s = {{"track", 12.5}};
  record.objects = {{"chair", 3}};
  record.path_error = batch::PathError{0.0125, 118, 120};
  json("batch_record", batch::EncodeRecord(record, "f"));
  batch::BatchState state;
  state.tool_version = "0.1.0";
  state.state = "done";
  state.engine = "local";
  state.captures = {record};
  json("batch", batch::EncodeBatch(state, "f"));
  batch::BatchPlan plan;
  plan.captures = {{"/data/kitchen", "kitchen"}};
  plan.run_options = "{}";
  plan.data_folder = "/data";
  json("batch_plan", batch::EncodePlan(plan, "f"));

  corpus.Put("map_json", "map", *EncodeMap(SampleMap(), "f"));
  const Odometry odometry = SampleOdometry();
  const std::string tum = *EncodeTum(StampedPoses(odometry.frames), "f");
  const std::string g2o = *G2oText(odometry);
  const std::string frames = *FramesText(odometry);
  corpus.Put("odometry", "whole", frames + "\n%\n" + tum + "\n%\n" + g2o);
  corpus.Put("trajectory", "tum", tum);
  corpus.Put("g2o", "odometry", g2o);
  corpus.Put("mask", "dotted", std::string("\x40\0\x30\0", 4) + EncodeRle(SampleMask(64, 48)));
  PlyMesh ply;
  ply.mesh.vertices = {{0, 0, 0}, {1, 0, 0.1F}, {0, 1, 0}, {0, 0, 1e-7F}};
  ply.mesh.faces = {{0, 1, 2}, {0, 3, 1}};
  corpus.Put("ply", "plain", *EncodePly(ply, "f"));
  ply.mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {255, 0, 128}};
  ply.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  ply.labels = {1, -1, 3, 4};
  corpus.Put("ply", "full", *EncodePly(ply, "f"));
}

void PutShapes(Corpus& corpus) {
  VoxelGrid grid;
  for (int i = 20; i < 40; ++i) {
    for (int j = 22; j < 40; ++j) {
      for (int k = 5; k < 30; ++k) grid.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  corpus.Put("binvox", "block", shape::WriteBinvox(grid));
  corpus.Put("binvox", "empty", shape::WriteBinvox(VoxelGrid()));
  corpus.Put("voxel_code", "block", shape::EncodeVoxels(grid));
  corpus.Put("voxel_code", "empty", shape::EncodeVoxels(VoxelGrid()));
}

void PutScenes(Corpus& corpus) {
  gltf::GltfScene scene = gltf::SmallScene();
  for (const bool draco : {true, false}) {
    gltf::GltfOptions options;
    options.draco = draco;
    const std::string glb = *gltf::WriteGlb(scene, options);
    const char* const name = draco ? "draco.glb" : "plain.glb";
    corpus.Put("glb", name, glb);
    corpus.Put("furniture_gltf", name, glb);
  }
  TriangleMesh box = gltf::BoxMesh(0.3F, 0.2F, 0.9F);
  const auto seed = [](const TriangleMesh& mesh) {
    return gltf::DracoEncode(gltf::MakeRenderMesh(mesh, 0.7), 12, 8)->bytes;
  };
  corpus.Put("draco", "box", seed(box));
  box.colours.assign(box.vertices.size(), {1, 200, 30});
  corpus.Put("draco", "coloured", seed(box));
}

void PutCaptures(Corpus& corpus) {
  for (const int codec : {0, 1, 2}) {
    layouts::foreign::SensOptions options;
    options.num_frames = 2;
    options.colour_codec = codec == 0 ? 1 : codec;  // raw colour is large
    options.depth_codec = codec;
    options.num_motions = codec;
    corpus.Put("sens", std::to_string(codec), layouts::foreign::Sens(options));
  }
  const std::string head = {'\x1F', '\0', '\x17', '\0'};  // 32 x 24
  corpus.Put("sens_depth", "raw", '\1' + head + layouts::foreign::RawDepth(0));
  corpus.Put("sens_depth", "zlib", '\2' + head + layouts::foreign::ZlibDepth(0));
  corpus.Put("sens_depth", "occi", '\3' + head + layouts::foreign::OcciDepth());
  const cv::Mat picture(6, 8, CV_8UC3, cv::Scalar(9, 80, 200));
  corpus.Put("image", "colour.png", layouts::foreign::Encoded(".png", picture));
  corpus.Put("image", "colour.jpg", layouts::foreign::Encoded(".jpg", picture));
  corpus.Put("image", "colour.bmp", layouts::foreign::Encoded(".bmp", picture));
  corpus.Put("image", "other_size.png", layouts::foreign::ColourFile(0));
  for (const char* const end : {".png", ".jpg", ".webp"})
    corpus.Put("texture", std::string("colour") + end, layouts::foreign::Encoded(end, picture));
}

void PutNetworks(Corpus& corpus) {
  constexpr std::size_t kAnchors = 64 + 16 + 4;
  TinyNetwork network;
  std::vector<float> head(6 * kAnchors, 0.0F);
  const std::vector<float> column = {32, 32, 20, 10, 0.1F, 0.9F};
  for (std::size_t row = 0; row < 6; ++row) head[row * kAnchors + 3] = column[row];
  network.outputs = {{{1, 6, static_cast<std::int64_t>(kAnchors)}, head}};
  network.metadata["names"] = "{0: 'chair', 1: 'dining table'}";
  corpus.Put("onnx", "yolov8", WriteOnnx(network));
  network.metadata.clear();
  corpus.Put("onnx", "nameless", WriteOnnx(network));
  corpus.Put("onnx_fitted", "raw", WriteOnnx(testing_support::GridNetwork()));
  testing_support::GridNetwork listed;
  listed.constants = testing_support::GridNetwork::Constants::kListed;
  corpus.Put("onnx_fitted", "listed", WriteOnnx(listed));
  std::string numbers = {'\2', '\1', '\3', '\1', '\6', static_cast<char>(kAnchors)};
  numbers.append(reinterpret_cast<const char*>(head.data()), head.size() * sizeof(float));
  corpus.Put("yolo_heads", "yolov8", numbers);

  TinyNetwork prior;
  prior.inputs = {{"crop", {1, 8, 128, 128}}};
  prior.outputs = {{{1, 4}, std::vector<float>(4, 0.1F), "sketch"}};
  for (const char* role : {"sketch", "decoder"}) {
    prior.metadata = {
        {"format", "deepslam/prior"}, {"version", "1"}, {"class", "chair"}, {"role", role}};
    corpus.Put("shape_prior", role, WriteOnnx(prior));
  }
}

}  // namespace
}  // namespace deepslam

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "deepslam_fuzz_seeds CORPUS\n";
    return 2;
  }
  deepslam::Corpus corpus(argv[1]);
  deepslam::PutArtifacts(corpus);
  deepslam::PutShapes(corpus);
  deepslam::PutScenes(corpus);
  deepslam::PutCaptures(corpus);
  deepslam::PutNetworks(corpus);
  return 0;
}
