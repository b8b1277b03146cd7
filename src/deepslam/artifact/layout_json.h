// layout.json: rooms, walls, openings, levels and slanted planes, in the level world.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/artifact/json_visitor.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/scene/layout.h"

namespace deepslam::artifact {

[[nodiscard]] Result<std::string> EncodeLayout(const Layout& layout, std::string_view name);
// Ids that name nothing, outlines that are no polygons and heights the wrong way round are refused.
[[nodiscard]] Result<Layout> DecodeLayout(TextSource text, std::string_view name);

// What other files have of a layout as well.

inline constexpr Range kPlanPlace_m{-1e6, 1e6};  // far beyond any home

void Describe(JsonVisitor& visitor, OpeningKind& kind);
// [x, y]
void Describe(JsonVisitor& visitor, Eigen::Vector2d& place_m);

// Field `polygon_m`: x, y of each corner in turn, three corners or more.
void DescribePolygon(JsonVisitor& visitor, std::vector<Eigen::Vector2d>& polygon_m);

// Fields `bottom_m` and `top_m` of what has a lower and an upper end.
template <typename T>
void DescribeHeights(JsonVisitor& visitor, T& value) {
  visitor.Field("bottom_m", value.bottom_m, kPlanPlace_m);
  visitor.Field("top_m", value.top_m, kPlanPlace_m);
  if (value.top_m < value.bottom_m) visitor.Fail("top_m", "must not be below bottom_m");
}

// Faults in `member` where one of these names a room that is not there.
void CheckRooms(JsonVisitor& visitor,
                std::string_view member,
                const std::vector<int>& rooms,
                std::size_t num_rooms);

}  // namespace deepslam::artifact
