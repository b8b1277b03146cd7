// The scene graph of a map; that its file fits the schema is shown where the program writes it
// (tests/exports).
#include "deepslam/presentation/scene_graph.h"

#include <limits>
#include <set>

#include <gmock/gmock.h>

#include "deepslam/presentation/labelled_scene.h"
#include "deepslam/presentation/scene_graph_json.h"
#include "presentation/room_with_box.h"
#include "support/layout_samples.h"

namespace deepslam::presentation {
namespace {

CompactMap MapOf(const FinishedMap& finished) {
  const gltf::GltfScene scene =
      MakeScene(finished, OneClass(), testing_support::SmallCamera(), SomeRun(), {});
  return MakeCompactMap(
      finished, scene, CodesOfRoomWithBox(), {SomeRun(), {Verdict::kDoubtful, {"few"}}, {}});
}

FinishedMap BoxesInRooms(const std::vector<Eigen::Vector3d>& places) {
  FinishedMap finished = RoomWithBox();
  finished.layout_world = testing_support::TwoRoomLayout();
  const MapObject object = finished.map.map.objects[0];
  const TriangleMesh mesh = finished.meshes[0];
  finished.map.map.objects.clear();
  finished.meshes.clear();
  for (const Eigen::Vector3d& place : places) {
    finished.map.map.objects.push_back(object);
    finished.map.map.objects.back().id = ObjectId{static_cast<int>(finished.meshes.size())};
    finished.map.map.objects.back().world_from_object.translation_m = place;
    finished.meshes.push_back(mesh);
  }
  return finished;
}

SceneGraph GraphOf(const FinishedMap& finished) {
  return MakeSceneGraph(MapOf(finished),
                        finished.meshes,
                        std::vector<double>(finished.meshes.size(), 1.0),
                        OneClass());
}

std::set<std::string> Sentences(const SceneGraph& graph) {
  std::set<std::string> sentences;
  const char* const names[] = {"against", "hangs", "before", "in", "beside", "on"};
  for (const GraphRelation& relation : graph.relations) {
    sentences.insert(relation.subject + " " + names[static_cast<int>(relation.predicate)] + " " +
                     relation.object);
  }
  return sentences;
}

TEST(MakeSceneGraph, RelatesThingsToRoomsWallsAndEachOther) {
  // Two cubes of a metre on the floor at the wall y = 0 of the first room, one on the first of
  // them, one in the other room.
  const SceneGraph graph =
      GraphOf(BoxesInRooms({{1, 0.52, 0.5}, {2.2, 0.52, 0.5}, {1, 0.52, 1.5}, {6, 1.5, 0.5}}));
  EXPECT_THAT(Sentences(graph),
              testing::UnorderedElementsAre("cabinet_00 in room_00",
                                            "cabinet_00 on floor",
                                            "cabinet_00 against wall_00",
                                            "cabinet_00 beside cabinet_01",
                                            "cabinet_01 in room_00",
                                            "cabinet_01 on floor",
                                            "cabinet_01 against wall_00",
                                            "cabinet_01 before cabinet_00",
                                            "cabinet_01 before cabinet_02",
                                            "cabinet_02 in room_00",
                                            "cabinet_02 on cabinet_00",
                                            "cabinet_02 against wall_00",
                                            "cabinet_03 in room_01",
                                            "cabinet_03 on floor"));
  EXPECT_EQ(graph.objects[3].room, 1);
}

TEST(MakeSceneGraph, BoxesHoldTheMesh) {
  FinishedMap finished = BoxesInRooms({{1, 1.5, 0.5}});
  finished.map.map.objects[0].world_from_object.rotation =
      Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitZ());
  for (Eigen::Vector3f& vertex : finished.meshes[0].vertices) vertex.x() += 0.25F;
  const GraphObject object = GraphOf(finished).objects[0];
  EXPECT_LT((object.size_m - Eigen::Vector3d(1, 1, 1)).norm(), 0.05) << object.size_m.transpose();
  const double moved = 0.25 * std::sqrt(0.5);
  EXPECT_LT((object.centre_world - Eigen::Vector3d(1 + moved, 1.5 + moved, 0.5)).norm(), 2e-4);
  for (const Eigen::Vector3f& vertex : finished.meshes[0].vertices) {
    const Eigen::Vector3d p = finished.map.map.objects[0].world_from_object * vertex.cast<double>();
    ASSERT_TRUE((p.array() >= object.box_world.min.array() - 1e-4).all());
    ASSERT_TRUE((p.array() <= object.box_world.max.array() + 1e-4).all());
  }
  EXPECT_GT(object.box_world.Size().x(), 1.3) << "a turned square is wider along the axes";
}

TEST(MakeSceneGraph, TakesLabelsAndFrontsFromTheTable) {
  ClassTable classes = OneClass();
  classes.classes[0].labels_elsewhere.nyu40 = ClassLabel{3, "cabinet"};
  classes.classes[0].traits.yaw_free = true;
  const FinishedMap finished = BoxesInRooms({{1, 0.52, 0.5}, {2.2, 0.52, 0.5}});
  const SceneGraph graph =
      MakeSceneGraph(MapOf(finished), finished.meshes, std::vector<double>{1, 1}, classes);
  EXPECT_EQ(graph.objects[0].labels.nyu40, (ClassLabel{3, "cabinet"}));
  EXPECT_FALSE(graph.objects[0].labels.coco.has_value());
  EXPECT_FALSE(graph.objects[0].has_front);
  for (const GraphRelation& relation : graph.relations)
    EXPECT_NE(relation.predicate, Predicate::kInFrontOf);
  const SceneGraph unknown =
      MakeSceneGraph(MapOf(finished), finished.meshes, std::vector<double>{1, 1}, {});
  EXPECT_EQ(unknown.objects[0].labels, CommonLabels());
}

TEST(MakeSceneGraph, BearsAnEmptyMapAndThingsWithoutASurface) {
  const SceneGraph none = GraphOf(BoxesInRooms({}));
  EXPECT_TRUE(none.objects.empty() && none.relations.empty());
  EXPECT_TRUE(EncodeSceneGraph(none, "f").ok());
  FinishedMap finished = BoxesInRooms({{1, 1.5, 0.5}, {1.1, 1.5, 0.5}});
  finished.meshes[0] = {};
  const SceneGraph graph = GraphOf(finished);
  EXPECT_FALSE(graph.objects[0].has_mesh);
  EXPECT_EQ(graph.objects[0].box_world.min, graph.objects[0].box_world.max);
  EXPECT_EQ(graph.objects[0].room, 0);
  EXPECT_TRUE(EncodeSceneGraph(graph, "f").ok());
}

TEST(EncodeSceneGraph, IsTheSameEveryTimeAndRefusesWhatIsNoNumber) {
  SceneGraph graph = GraphOf(BoxesInRooms({{1, 0.52, 0.5}, {2.2, 0.52, 0.5}}));
  EXPECT_EQ(*EncodeSceneGraph(graph, "f"), *EncodeSceneGraph(graph, "f"));
  graph.objects[0].volume_m3 = std::numeric_limits<double>::quiet_NaN();
  const Result<std::string> text = EncodeSceneGraph(graph, "scene_graph.json");
  ASSERT_FALSE(text.ok());
  EXPECT_THAT(text.error().message, testing::HasSubstr("scene_graph.json"));
}

}  // namespace
}  // namespace deepslam::presentation
