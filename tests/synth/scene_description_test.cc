#include "deepslam/synth/scene_description.h"

#include <cmath>

#include <gmock/gmock.h>

namespace deepslam::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string Refusal(const std::string& text) {
  const Result<SceneDescription> scene = ParseScene(text, "room.yaml");
  if (scene.ok()) return "";
  EXPECT_EQ(scene.error().code, ErrorCode::kInvalidConfig);
  return scene.error().message;
}

TEST(ParseScene, ReadsEveryPart) {
  const Result<SceneDescription> scene = ParseScene(
      "seed: 5\nframes: 30\nframes_per_s: 15\n"
      "camera: {width: 320, height: 240, fx: 260, fy: 261, cx: 160, cy: 120}\n"
      "room: {size_m: [4, 5, 2.4], floor: carpet, wall_colour_rgb: [1, 2, 3], posters: 2}\n"
      "lights: [{position_m: [1, 2, 2.3], power: 3}]\n"
      "objects:\n  - {class: chair, model: \"A#b\", position_m: [0.5, -1], yaw_deg: 90}\n"
      "orbit: {radius_m: 1.5, sweep_deg: -90}\nfaults: {depth_noise: false}\n",
      "room.yaml");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->seed, 5u);
  EXPECT_EQ(scene->num_frames, 30);
  EXPECT_EQ(scene->camera, (PinholeCamera{320, 240, 260, 261, 160, 120}));
  EXPECT_EQ(scene->room_size_m, Eigen::Vector3d(4, 5, 2.4));
  EXPECT_EQ(scene->wall_colour, (Rgb8{1, 2, 3}));
  ASSERT_EQ(scene->lights.size(), 1u);
  EXPECT_EQ(scene->lights[0].power, 3);
  ASSERT_EQ(scene->objects.size(), 1u);
  EXPECT_EQ(scene->objects[0].model, "A#b");
  EXPECT_EQ(scene->objects[0].yaw_deg, 90);
  EXPECT_EQ(scene->objects[0].line, 8);
  EXPECT_EQ(scene->orbit.sweep_deg, -90);
  EXPECT_FALSE(scene->faults.axial_noise);
  EXPECT_FALSE(scene->faults.quantisation);
  EXPECT_TRUE(scene->faults.grazing_holes);
}

TEST(ParseScene, ReadsWhatIsNotInEveryScene) {
  const Result<SceneDescription> scene = ParseScene(
      "camera: {preset: kinect_v2, fx: 370}\n"
      "openings: [{wall: south, from_m: 1, width_m: 2, bottom_m: 0.5, height_m: 1}]\n"
      "clutter: {floor_boxes: 2, per_table: 4}\n"
      "objects: [{class: table, model: a.obj, position_m: [0, 0], size_m: [1, 2, 0.7]}]\n"
      "walk: {points_m: [[1, 2, 1.5], [2, 2, 1.5]], look_at_m: [[0, 0, 0.5]], closed: true}\n"
      "faults: {all: false, shadows: true, noise_scale: 2, table_edges_m: 0.03}\n",
      "room.yaml");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->camera, (PinholeCamera{512, 424, 370, 365.5, 255.5, 211.5}));
  EXPECT_EQ(scene->sensor.name, "kinect_v2");
  ASSERT_EQ(scene->openings.size(), 1u);
  EXPECT_EQ(scene->openings[0].wall, 3);
  EXPECT_EQ(scene->clutter.num_per_table, 4);
  EXPECT_EQ(scene->objects[0].size_m, Eigen::Vector3d(1, 2, 0.7));
  EXPECT_EQ(scene->walk.points_m.size(), 2u);
  EXPECT_TRUE(scene->walk.closed);
  EXPECT_FALSE(scene->faults.axial_noise);
  EXPECT_TRUE(scene->faults.shadows);
  EXPECT_EQ(scene->faults.noise_scale, 2);
  EXPECT_EQ(scene->faults.table_edges_m, 0.03);
}

TEST(ParseScene, SmallerPicturesShowTheSameSensor) {
  const DepthSensor whole = *DepthSensorPreset("kinect_v1");
  EXPECT_EQ(ParseScene("seed: 1\n", "room.yaml")->sensor.lateral_px, whole.lateral_px);
  const DepthSensor half =
      ParseScene(
          "camera: {preset: kinect_v1, width: 320, height: 240, fx: 262, fy: 262, cx: 160, "
          "cy: 120}\n",
          "room.yaml")
          ->sensor;
  EXPECT_DOUBLE_EQ(half.lateral_px, whole.lateral_px / 2);
  EXPECT_DOUBLE_EQ(half.noise_reach_px, whole.noise_reach_px / 2);
  EXPECT_EQ(half.axial_constant_m, whole.axial_constant_m);
  EXPECT_EQ(ParseScene("camera: {preset: phone_lidar, width: 64, height: 48, cx: 31, cy: 23}\n",
                       "room.yaml")
                ->sensor.cell_px,
            1);
}

TEST(ParseScene, RungsReplaceFieldByField) {
  const std::string text =
      "seed: 1\nframes: 40\nfaults: {noise_scale: 3, shadows: false}\n"
      "rungs:\n  few: {frames: 10, faults: {noise_scale: 1}}\n  same: {}\n  bad: {frames: x}\n";
  EXPECT_EQ(ParseScene(text, "room.yaml")->num_frames, 40);
  EXPECT_EQ(ParseScene(text, "room.yaml", "same")->num_frames, 40);
  const Result<SceneDescription> few = ParseScene(text, "room.yaml", "few");
  ASSERT_TRUE(few.ok()) << few.error().message;
  EXPECT_EQ(few->num_frames, 10);
  EXPECT_EQ(few->faults.noise_scale, 1);
  EXPECT_FALSE(few->faults.shadows);
  EXPECT_THAT(ParseScene(text, "room.yaml", "none").error().message,
              AllOf(HasSubstr("'none'"), HasSubstr("few")));
  EXPECT_THAT(ParseScene(text, "room.yaml", "bad").error().message, HasSubstr("room.yaml:7"));
}

// It replaces the table of rungs while it is gone through itself.
TEST(ParseScene, ARungThatHoldsRungsChangesTheRestAsItSays) {
  const std::string text =
      "frames: 40\nrungs: {few: {frames: 10, rungs: {few}, frames_per_s: 7, seed: 3}}\n";
  const Result<SceneDescription> few = ParseScene(text, "room.yaml", "few");
  ASSERT_TRUE(few.ok()) << few.error().message;
  EXPECT_EQ(few->num_frames, 10);
  EXPECT_EQ(few->frames_per_s, 7);
  EXPECT_EQ(few->seed, 3U);
}

TEST(AtFrameRate, FilmsTheSameTimeAndRefusesWhatIsNoRate) {
  SceneDescription scene;
  scene.num_frames = 120;
  scene.frames_per_s = 30;
  const Result<SceneDescription> slower = AtFrameRate(scene, 5);
  ASSERT_TRUE(slower.ok()) << slower.error().message;
  EXPECT_EQ(slower->num_frames, 20);
  EXPECT_EQ(slower->frames_per_s, 5);
  EXPECT_EQ(AtFrameRate(scene, 0.1)->num_frames, 1);  // never none
  for (const double wrong : {0.0, -5.0, std::nan(""), 1e9})
    EXPECT_THAT(AtFrameRate(scene, wrong).error().message, HasSubstr("from 0.1 to 1000"));
  scene.num_frames = 100'000;
  EXPECT_THAT(AtFrameRate(scene, 60).error().message, HasSubstr("slower rate"));
}

TEST(FilmedWith, ReplacesOneFieldAndKeepsTheRest) {
  const std::string text =
      "seed: 3\ncamera: {preset: d435, width: 320, height: 240, fx: 300, fy: 300, cx: 160, cy: "
      "120}\n"
      "faults: {noise_scale: 2}\nwalk: {points_m: [[0, 0, 1], [1, 0, 1]]}\n";
  const Result<SceneDescription> scene = ParseScene(text, "room.yaml");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Result<SceneDescription> holes = FilmedWith(*scene, "faults.missing_share=0.25");
  ASSERT_TRUE(holes.ok()) << holes.error().message;
  EXPECT_EQ(holes->faults.missing_share, 0.25);
  EXPECT_EQ(holes->faults.noise_scale, 2);
  EXPECT_EQ(holes->camera.fx, 300);
  EXPECT_EQ(holes->sensor.name, "d435");
  EXPECT_EQ(holes->sensor.lateral_px, scene->sensor.lateral_px);
  const Result<SceneDescription> phone = FilmedWith(*scene, "camera.preset=phone_lidar");
  ASSERT_TRUE(phone.ok()) << phone.error().message;
  EXPECT_EQ(phone->sensor.name, "phone_lidar");
  EXPECT_EQ(phone->camera.width, DepthSensorPreset("phone_lidar")->camera.width);
  EXPECT_EQ(phone->faults.noise_scale, 2);
  const Result<SceneDescription> other = FilmedWith(*scene, "walk.points_m=[[0, 0, 2], [0, 1, 2]]");
  ASSERT_TRUE(other.ok()) << other.error().message;
  ASSERT_EQ(other->walk.points_m.size(), 2u);
  EXPECT_EQ(other->walk.points_m[1].z(), 2);
}

TEST(FilmedWith, RefusesByOptionAndField) {
  const auto refusal = [](const std::string& setting) {
    const Result<SceneDescription> scene = FilmedWith({}, setting);
    return scene.ok() ? "" : scene.error().message;
  };
  EXPECT_THAT(refusal("camera.preset=d453"), HasSubstr("did you mean d435"));
  EXPECT_THAT(refusal("camera.preset=d453"), HasSubstr("--field camera.preset=d453: field"));
  EXPECT_THAT(refusal("faults.noise_scale=-1"), HasSubstr("'faults.noise_scale' is '-1'"));
  EXPECT_THAT(refusal("faults.noise=1"), HasSubstr("'faults.noise' is unknown"));
  EXPECT_THAT(refusal("objects=[]"), HasSubstr("'objects' is unknown"));
  EXPECT_THAT(refusal("faults=1"), HasSubstr("'faults' is not a table"));
  EXPECT_THAT(refusal("walk.points_m=[[0, 0, 1]]"), HasSubstr("two or more"));
  for (const char* broken : {"", "=", "=1", "faults", "faults.rim", ".=1", "a..b=1", "faults.=1"})
    EXPECT_NE(refusal(broken), "") << broken;
  EXPECT_THAT(refusal("faults.rim=[1"), HasSubstr("not valid YAML"));
}

TEST(ParseScene, RefusesByFileLineAndField) {
  EXPECT_THAT(Refusal(""), HasSubstr("room.yaml: holds no scene"));
  EXPECT_THAT(Refusal("frames: [1"), AllOf(HasSubstr("room.yaml:"), HasSubstr("not valid YAML")));
  EXPECT_THAT(Refusal("seed: 1\nframes: 0\n"),
              AllOf(HasSubstr("room.yaml:2"), HasSubstr("'frames' is '0'")));
  EXPECT_THAT(Refusal("frames: 1.5\n"), HasSubstr("whole number"));
  EXPECT_THAT(Refusal("frames: many\n"), HasSubstr("'many'"));
  EXPECT_THAT(Refusal("frames: .nan\n"), HasSubstr("'frames'"));
  EXPECT_THAT(Refusal("frames: 1000000000\n"), HasSubstr("'frames'"));
  EXPECT_THAT(Refusal("seed: 1\nroms: {}\n"),
              AllOf(HasSubstr("room.yaml:2"),
                    HasSubstr("'roms' is unknown"),
                    HasSubstr("did you mean room?")));
  EXPECT_THAT(Refusal("room: {size_m: [4, 5]}\n"),
              HasSubstr("'room.size_m' is not a list of 3 numbers"));
  EXPECT_THAT(Refusal("room: {floor: lava}\n"),
              AllOf(HasSubstr("'room.floor'"), HasSubstr("lava"), HasSubstr("carpet")));
  EXPECT_THAT(Refusal("room: 5\n"), HasSubstr("'room' is not a table"));
  EXPECT_THAT(Refusal("camera: {width: 100000}\n"), HasSubstr("'camera.width'"));
  EXPECT_THAT(Refusal("objects: [{class: chair, position_m: [0, 0]}]\n"),
              HasSubstr("'objects[0].model' is missing"));
  EXPECT_THAT(Refusal("objects:\n  - {class: chair, model: a, position_m: [0, x]}\n"),
              AllOf(HasSubstr("room.yaml:2"), HasSubstr("'objects[0].position_m[1]' is 'x'")));
  EXPECT_THAT(Refusal("seed: 1\ncamera: {preset: kinect_v1x}\n"),
              AllOf(HasSubstr("room.yaml:2"),
                    HasSubstr("'camera.preset' is 'kinect_v1x'"),
                    HasSubstr("did you mean kinect_v1?"),
                    HasSubstr("d435")));
  EXPECT_THAT(Refusal("walk: {points_m: [[0, 0, 1]]}\n"), HasSubstr("two or more"));
  EXPECT_THAT(Refusal("walk: {points_m: [[0, 0, 1], [0, 1]]}\n"),
              HasSubstr("'walk.points_m[1]' is not a point"));
  EXPECT_THAT(Refusal("walk: {points_m: [[0, 0, 1], [1, 1, .nan]]}\n"), HasSubstr("not a point"));
  EXPECT_THAT(Refusal("openings: [{wall: up}]\n"), AllOf(HasSubstr("'up'"), HasSubstr("east")));
  EXPECT_THAT(Refusal("partitions: [{from_m: [0, 0], to_m: [1, 1]}]\n"),
              AllOf(HasSubstr("'partitions[0].to_m'"), HasSubstr("along x or along y")));
  EXPECT_THAT(Refusal("partitions: [{from_m: [0, 0]}]\n"), HasSubstr("to_m' is missing"));
  EXPECT_THAT(
      Refusal("partitions: [{from_m: [0, 0], to_m: [2, 0], openings: [{width_m: wide}]}]\n"),
      HasSubstr("'partitions[0].openings[0].width_m' is 'wide'"));
  EXPECT_THAT(Refusal("faults: {missing_share: 2}\n"), HasSubstr("'faults.missing_share' is '2'"));
  EXPECT_THAT(Refusal("lights: 3\n"), HasSubstr("'lights' is not a list"));
  EXPECT_THAT(Refusal("faults: {depth_noise: perhaps}\n"), HasSubstr("true or false"));
}

}  // namespace
}  // namespace deepslam::synth
