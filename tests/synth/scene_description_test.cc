#include "deepslam/synth/scene_description.h"

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
  EXPECT_FALSE(scene->faults.depth_noise);
  EXPECT_TRUE(scene->faults.depth_holes);
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
              AllOf(HasSubstr("room.yaml:2"), HasSubstr("'roms' is unknown"), HasSubstr("room")));
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
  EXPECT_THAT(Refusal("lights: 3\n"), HasSubstr("'lights' is not a list"));
  EXPECT_THAT(Refusal("faults: {depth_noise: perhaps}\n"), HasSubstr("true or false"));
}

}  // namespace
}  // namespace deepslam::synth
