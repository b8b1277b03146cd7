#include "deepslam/report/plan_dxf.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "report/two_room_plan.h"

namespace deepslam::report {
namespace {

// An entity's groups, by code; those of a polyline's vertices are entities of their own.
struct Entity {
  std::string kind;
  std::multimap<int, std::string> groups;

  [[nodiscard]] std::string Text(int code) const {
    const auto found = groups.find(code);
    return found == groups.end() ? "" : found->second;
  }
  [[nodiscard]] double Number(int code) const { return std::stod(Text(code)); }
};

// A reader of release 12 in ASCII that is no more than pairs of lines: code, value.
std::vector<Entity> ReadDxf(const std::string& dxf) {
  std::vector<Entity> entities;
  std::istringstream lines(dxf);
  std::string code;
  std::string value;
  while (std::getline(lines, code) && std::getline(lines, value)) {
    const int number = std::stoi(code);
    if (number == 0) entities.push_back({value, {}});
    if (number != 0) entities.back().groups.emplace(number, value);
  }
  return entities;
}

std::vector<Entity> Of(const std::vector<Entity>& all,
                       const std::string& layer,
                       const std::string& kind) {
  std::vector<Entity> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some), [&](const Entity& entity) {
    return entity.kind == kind && entity.Text(8) == layer;
  });
  return some;
}

TEST(FloorPlanDxf, IsTrueToScaleOnItsLayers) {
  const std::vector<Entity> all = ReadDxf(FloorPlanDxf(TwoRoomPlan()));
  EXPECT_EQ(all.front().kind, "SECTION");
  EXPECT_EQ(all.back().kind, "EOF");
  std::set<std::string> layers;
  for (const Entity& entity : all) {
    if (entity.kind == "LAYER") layers.insert(entity.Text(2));
  }
  EXPECT_THAT(layers, testing::ElementsAre("DOORS", "FURNITURE", "TEXT", "WALLS", "WINDOWS"));
  // The leaf: an arc about its hinge by a right angle, as wide as the door.
  const std::vector<Entity> arcs = Of(all, "DOORS", "ARC");
  ASSERT_EQ(arcs.size(), 1U);
  EXPECT_NEAR(arcs[0].Number(40), 0.9, 1e-4);
  const double turned = arcs[0].Number(51) - arcs[0].Number(50);
  EXPECT_NEAR(turned < 0 ? turned + 360 : turned, 90, 1e-3);
  EXPECT_EQ(Of(all, "WINDOWS", "LINE").size(), 6U) << "two jambs, two faces, two panes";
  EXPECT_EQ(Of(all, "FURNITURE", "VERTEX").size(), 4U);
  std::vector<std::string> texts;
  for (const Entity& text : Of(all, "TEXT", "TEXT")) texts.push_back(text.Text(1));
  EXPECT_THAT(texts,
              testing::IsSupersetOf({"Room 0", "Room 1", "12.0 m2", "table_02", "4.00", "3.00"}));
}

// No piece of wall is drawn within an opening, on either face.
TEST(FloorPlanDxf, WallsAreOpenWhereDoorsAre) {
  const std::vector<Entity> all = ReadDxf(FloorPlanDxf(TwoRoomPlan()));
  int num_beside = 0;
  for (const Entity& line : Of(all, "WALLS", "LINE")) {
    if (std::abs(line.Number(10) - line.Number(11)) > 1e-6 || line.Number(10) < 3.9 ||
        line.Number(10) > 4.2)
      continue;
    const double low = std::min(line.Number(20), line.Number(21));
    const double high = std::max(line.Number(20), line.Number(21));
    EXPECT_TRUE(high <= 1 + 1e-4 || low >= 1.9 - 1e-4) << low << " to " << high;
    ++num_beside;
  }
  EXPECT_EQ(num_beside, 4) << "below and above the door, on both faces";
}

TEST(FloorPlanDxf, KeepsToPlainAsciiAndNeedsNoContent) {
  FloorPlanContent content = TwoRoomPlan();
  content.things[0].name = "ta\nble\xc3\xa9\t\x01";
  const std::string dxf = FloorPlanDxf(content);
  EXPECT_TRUE(std::all_of(
      dxf.begin(), dxf.end(), [](char c) { return c == '\n' || (c >= 0x20 && c < 0x7F); }));
  const std::vector<Entity> all = ReadDxf(dxf);
  EXPECT_EQ(all.back().kind, "EOF");
  std::vector<std::string> texts;
  for (const Entity& text : Of(all, "TEXT", "TEXT")) texts.push_back(text.Text(1));
  EXPECT_THAT(texts, testing::Contains("ta?ble???"));
  EXPECT_EQ(ReadDxf(FloorPlanDxf({})).back().kind, "EOF");
  EXPECT_EQ(FloorPlanDxf(content), dxf);
}

}  // namespace
}  // namespace deepslam::report
