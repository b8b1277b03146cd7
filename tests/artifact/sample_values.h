// Scene values with every field set to something that is not its default, for round trips.
#pragma once

#include "deepslam/artifact/detections_json.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/pose_graph_g2o.h"
#include "deepslam/artifact/segments_json.h"
#include "deepslam/artifact/summary_json.h"
#include "deepslam/artifact/trajectory_files.h"
#include "deepslam/core/random.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::testing_support {

inline Pose3 SamplePose(Random& random) {
  const Eigen::Vector3d axis(random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(-2, 2));
  return {RotationFromVector(axis),
          Eigen::Vector3d(random.Uniform(-9, 9), random.Uniform(-9, 9), 1.0 / 3.0)};
}

inline Matrix6d SampleInformation(Random& random) {
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = random.Uniform(-30, 30);
  const Matrix6d information = root * root.transpose() + Matrix6d::Identity();
  // Products of floats are symmetric up to rounding; edges promise exact symmetry.
  return 0.5 * (information + information.transpose());
}

inline Mask SampleMask(int width, int height) {
  Mask mask(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) mask(u, v) = (u * u + 3 * v) % 7 < 3 ? 1 : 0;
  }
  return mask;
}

inline Odometry SampleOdometry() {
  Random random(1);
  Odometry odometry;
  for (int i = 0; i < 5; ++i) {
    odometry.frames.push_back({FrameIdx{i},
                               1305031102.1758 + i / 30.0,
                               SamplePose(random),
                               static_cast<TrackingStatus>(i % 4),
                               FrameIdx{i / 2 * 2},
                               0.004321,
                               0.87});
  }
  odometry.keyframes = {FrameIdx{0}, FrameIdx{2}, FrameIdx{4}};
  odometry.edges = {
      {FrameIdx{0}, FrameIdx{2}, SamplePose(random), SampleInformation(random), false},
      {FrameIdx{2}, FrameIdx{4}, SamplePose(random), SampleInformation(random), true}};
  return odometry;
}

// odometry.g2o.
inline Result<std::string> G2oText(const Odometry& odometry) {
  return WholeText(
      [&](const TextSink& sink) { return artifact::EncodeG2o(odometry, "file", sink); });
}
inline Result<std::vector<RelativePose>> G2oEdges(TextSource text, std::string_view name) {
  std::vector<RelativePose> edges;
  const Status read =
      artifact::DecodeG2oEdges(std::move(text), name, [&](const RelativePose& edge) {
        edges.push_back(edge);
        return Ok();
      });
  if (!read.ok()) return read.error();
  return edges;
}

inline Result<Odometry> OdometryOf(artifact::OdometryTexts texts) {
  Odometry odometry;
  const Result<Trajectory> read =
      artifact::DecodeOdometry(std::move(texts), [&](const RelativePose& edge) {
        odometry.edges.push_back(edge);
        return Ok();
      });
  if (!read.ok()) return read.error();
  static_cast<Trajectory&>(odometry) = *read;
  return odometry;
}

// frames.json.
inline Result<std::string> FramesText(const Odometry& odometry) {
  return artifact::EncodeFrames(odometry.frames, odometry.keyframes, JoinsOf(odometry), "file");
}

// segments.json.
inline Result<std::string> SegmentsText(const std::vector<Segment>& segments) {
  return WholeText(
      [&](const TextSink& sink) { return artifact::EncodeSegments(segments, "file", sink); });
}

inline Ground SampleGround() {
  Ground ground;
  ground.plane_world = Plane{Eigen::Vector3d(0.6, 0.0, 0.8), 1.234567890123};
  ground.observations = {{FrameIdx{2},
                          {Eigen::Vector3d(0, -1, 0), 1.1},
                          (Eigen::Matrix3d() << 5, 0.1, 0.2, 0.1, 6, 0.3, 0.2, 0.3, 7).finished(),
                          4321}};
  ground.apart = {{FrameIdx{3}, FrameIdx{4}, Plane{Eigen::Vector3d(0, 0.6, 0.8), 0.7}},
                  {FrameIdx{5}, FrameIdx{9}, std::nullopt}};
  return ground;
}

inline artifact::DetectionTable SampleDetections() {
  artifact::DetectionTable table;
  table.images = {{FrameIdx{0}, "rgb/000000.jpg", 64, 48}, {FrameIdx{3}, "rgb/000003.jpg", 64, 48}};
  table.detections = {{DetectionId{0},
                       FrameIdx{0},
                       "chair",
                       0.75,
                       {1.5, 2.25, 30, 40},
                       DetectionSource::kNetwork,
                       {}},
                      {DetectionId{1},
                       FrameIdx{3},
                       "table",
                       0.5,
                       {0, 0, 63, 47},
                       DetectionSource::kFile,
                       SampleMask(64, 48)},
                      {DetectionId{2},
                       FrameIdx{3},
                       "furniture",
                       0.25,
                       {4, 5, 20, 21},
                       DetectionSource::kCluster,
                       {}}};
  return table;
}

inline std::vector<Segment> SampleSegments() {
  Segment segment{DetectionId{1},
                  FrameIdx{3},
                  "table",
                  0.5,
                  DetectionSource::kCluster,
                  {0, 0, 63, 47},
                  SampleMask(64, 48),
                  99,
                  {},
                  0.31,
                  true,
                  true,
                  ""};
  segment.extent_camera.Extend(Eigen::Vector3d(-0.1, 0.2, 1.3));
  segment.extent_camera.Extend(Eigen::Vector3d(0.4, 0.5, 2.6));
  Segment empty;
  empty.detection = DetectionId{2};
  empty.frame = FrameIdx{3};
  empty.class_name = "chair";
  empty.reason = "no depth \"at all\"";
  return {segment, empty};
}

inline Association SampleAssociation() {
  Association association;
  association.tracks = {{ObjectId{4},
                         "chair",
                         {{DetectionId{1}, FrameIdx{3}, 5, 0.0123, "vote"},
                          {DetectionId{9}, FrameIdx{4}, 0, 0, "new"}},
                         "no object near",
                         {{"chair", 1.3}, {"table", 0.4}}}};
  association.rejections = {{DetectionId{7}, FrameIdx{2}, "touches border"}};
  association.not_mapped = {
      {"shelf at 1.00, 2.00: only 0.04 m deep", {FrameIdx{4}, {10, 20, 110, 60}}}};
  return association;
}

inline Proposals SampleProposals() {
  Proposals proposals;
  proposals.candidates = {
      {CandidateId{0},
       ObjectId{4},
       CandidateSource::kNetwork,
       DetectionId{1},
       "obj4_a",
       0.66,
       0.9,
       0.7,
       1.1,
       {0.1F, -3.25e-7F, 12345.678F},
       "",
       "",
       Eigen::Vector3d::Ones(),
       Similarity3{0.9, Eigen::Quaterniond(0.6, 0, 0, 0.8), {1.25, -0.5, 0.45}}},
      {CandidateId{1},
       ObjectId{4},
       CandidateSource::kRetrieval,
       DetectionId{},
       "lib-7",
       0.5,
       0.8,
       0.6,
       1.0,
       {},
       "Scopia/chair_3",
       "Ana, CC-BY",
       Eigen::Vector3d::Ones(),
       std::nullopt}};
  proposals.models.emplace("obj4_a", VoxelGrid());
  proposals.models.emplace("lib-7", VoxelGrid());
  proposals.notes = {"furniture has no prior"};
  return proposals;
}

inline ViewRegistration SampleView(Random& random) {
  return {DetectionId{1},
          FrameIdx{3},
          true,
          "",
          SamplePose(random),
          0.012,
          0.8,
          SampleInformation(random),
          true};
}

inline std::vector<CandidateRegistration> SampleRegistrations() {
  Random random(2);
  return {{CandidateId{0},
           true,
           "",
           0.93,
           SamplePose(random),
           {SampleView(random), SampleView(random)}},
          {CandidateId{1}, false, "too few points", 0, {}, {}}};
}

inline ObjectMap SampleObjects() {
  Random random(3);
  MapObject object;
  object.id = ObjectId{4};
  object.class_name = "chair";
  object.class_votes = {{"chair", 1.3}, {"table", 0.4}};
  object.chosen = CandidateId{1};
  object.source = CandidateSource::kFused;
  object.model = "lib-7";
  object.library_id = "Scopia/chair_3";
  object.credit = "Ana, CC-BY";
  object.scale_m = 0.87;
  object.world_from_object = SamplePose(random);
  object.confidence = 0.71;
  object.note = "leans";
  object.views = {SampleView(random)};
  CandidateScore score;
  score.candidate = CandidateId{1};
  score.score = 0.7;
  score.surface_share = 0.8;
  score.reached_share = 0.9;
  score.front_blocked = 0.5;
  score.coverage_share = 0.6;
  score.free_violation = 0.1;
  score.num_views = 3;
  score.seen_share = 0.45;
  score.note = "fine";
  score.views = {{DetectionId{1}, FrameIdx{3}, 77, 0.8, 99, 0.6, 0.1}};
  object.scores = {score};
  object.history = {{FrameIdx{3}, CandidateId{0}, 0.4}, {FrameIdx{4}, CandidateId{1}, 0.7}};
  object.merged = {ObjectId{9}};
  return {{object}, {"table_02: no candidate"}};
}

inline Loops SampleLoops() {
  Random random(4);
  return {{{{{ObjectId{1}, ObjectId{5}}, {ObjectId{2}, ObjectId{6}}},
            SamplePose(random),
            0.07,
            true,
            "agrees"}},
          {{ObjectId{1}, ObjectId{5}}},
          {{FrameIdx{0}, FrameIdx{4}, SamplePose(random), SampleInformation(random), true}},
          {{FrameIdx{1}, FrameIdx{9}, SamplePose(random), 41, 3, 0.9, true, "agrees"}},
          {{ObjectId{5}, ObjectId{1}, FrameIdx{70}, FrameIdx{90}}}};
}

inline artifact::OptimizationRecord SampleOptimization() {
  return {{true, 17, "CONVERGENCE", {{"r_io", 12, 345.6, 78.9}, {"loop", 0, 0, 0}}, 1},
          {Eigen::Vector3d::UnitZ(), 0},
          true};
}

inline CompactMap SampleMap() {
  Random random(5);
  CompactMap map;
  map.tool_version = "0.1.0";
  map.capture_name = "kitchen";
  map.capture_hash = "ab12";
  map.ground_world = Plane{};
  map.ground_outline_m = {{-1.25, 0}, {2, 0.125}, {1, 3}};
  map.class_colours = {{"chair", {1, 2, 255}}};
  map.mesh_options = {{"mesh.surface.iterations", "20"}};
  map.verdict = Verdict::kDoubtful;
  map.reasons = {"no \"ground\""};
  map.objects = {{ObjectId{4},
                  "chair_04",
                  "chair",
                  0.7,
                  CandidateSource::kRetrieval,
                  SamplePose(random),
                  0.9,
                  Eigen::Vector3d(0.4, 0.5, 0.9),
                  "Ana",
                  "",
                  {{}, "Scopia/chair_3", "cd34", {1.1, 0.95, 1}, "ef56", ""}},
                 {ObjectId{5},
                  "table_05",
                  "table",
                  0.6,
                  CandidateSource::kFused,
                  SamplePose(random),
                  1.9,
                  Eigen::Vector3d(1.4, 0.5, 0.7),
                  "",
                  "low",
                  {{}, "", "", Eigen::Vector3d::Ones(), "", std::string("DRACO\0\xff\x10", 8)}},
                 {ObjectId{6},
                  "sofa_06",
                  "sofa",
                  0.6,
                  CandidateSource::kNetwork,
                  SamplePose(random),
                  1.9,
                  Eigen::Vector3d(1.4, 0.5, 0.7),
                  "",
                  "",
                  {{0.5F, -0.1F}, "", "", Eigen::Vector3d::Ones(), "", ""}}};
  map.layout.emplace();
  map.layout->rooms = {{{{0, 0}, {4.125, 0}, {4, 3}}, 0.01, 2.5},
                       {{{0, 0}, {-1, 0.5}, {-1, -0.5}, {0, -1}}, 0, std::nullopt}};
  map.layout->walls = {{{0, 1}, {0, 0}, {4.125, 0}, 0.01, 2.5, 0.75, 0.9},
                       {{}, {0, 5}, {4, 5}, 0, 2.0, 0.5, 0.25}};
  map.layout->openings = {{0, OpeningKind::kWindow, {1, 0}, {2, 0}, 0.9, 2.1, 0.5},
                          {1, OpeningKind::kPassage, {1, 5}, {2, 5}, 0, 2, 0.75}};
  map.objects[0].room = 1;
  map.objects[0].stands_on = "table_05";
  map.objects[1].against_wall = 1;
  map.objects[1].stands_on = kOnFloor;
  return map;
}

}  // namespace deepslam::testing_support
