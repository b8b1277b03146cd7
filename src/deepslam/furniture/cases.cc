// Cabinets. Doors, drawers and open sides are at the front, +x.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct Case {
  Eigen::Vector3d size;  // of the body
  double low = 0;        // its underside

  [[nodiscard]] double MiddleZ() const { return low + 0.5 * size.z(); }
};

// A front leaf: door or drawer, with its handle.
void Leaf(const Case& body,
          const Eigen::Vector2d& middle_yz,
          const Eigen::Vector2d& size_yz,
          std::size_t handle,
          double handle_side,
          Solids& solids) {
  const double x = 0.5 * body.size.x();
  solids.Box(Material::kTop,
             {x + 0.008, middle_yz.x(), middle_yz.y()},
             {0.018, size_yz.x() - 0.008, size_yz.y() - 0.008});
  const bool drawer = handle_side == 0;
  const double y = middle_yz.x() + handle_side * (0.5 * size_yz.x() - 0.05);
  if (handle == 0) {
    solids.Cushion(Material::kDetail, {x + 0.03, y, middle_yz.y()}, {0.035, 0.035, 0.035}, 1, 1);
  } else if (handle == 1) {
    const Eigen::Vector3d size = drawer ? Eigen::Vector3d(0.02, 0.45 * size_yz.x(), 0.015)
                                        : Eigen::Vector3d(0.02, 0.015, 0.16);
    solids.Box(Material::kDetail, {x + 0.03, y, middle_yz.y()}, size);
  }
}

void Front(Random& random, const Case& body, Solids& solids) {
  const std::size_t handle = Pick(random, std::array{1.0, 1.0, 0.5});
  const int columns = body.size.y() < 0.55  ? 1
                      : body.size.y() < 1.1 ? Count(random, 1, 2)
                                            : Count(random, 2, 4);
  const double width = (body.size.y() - 0.02) / columns;
  for (int c = 0; c < columns; ++c) {
    const double y = -0.5 * body.size.y() + 0.01 + width * (c + 0.5);
    const int drawers = Chance(random, 0.45) ? Count(random, 1, 5) : 0;
    const double share =
        drawers == 0 ? 0.0 : (Chance(random, 0.5) ? 1.0 : random.Uniform(0.2, 0.5));
    const double height = share * (body.size.z() - 0.02);
    for (int n = 0; n < drawers; ++n) {
      const double z = body.low + body.size.z() - 0.01 - height * (n + 0.5) / drawers;
      Leaf(body, {y, z}, {width, height / drawers}, handle, 0, solids);
    }
    const double rest = body.size.z() - 0.02 - height;
    if (rest > 0.1) {
      const double side = c % 2 == 0 ? 1.0 : -1.0;
      Leaf(body, {y, body.low + 0.01 + 0.5 * rest}, {width, rest}, handle, side, solids);
    }
  }
}

double DrawFeet(Random& random) { return Chance(random, 0.6) ? random.Uniform(0.03, 0.2) : 0.0; }

Eigen::Vector3d DrawCabinetSize(Random& random) {
  switch (Pick(random, std::array{1.0, 1.0, 0.8, 0.6})) {
    case 0:  // sideboard
      return {random.Uniform(0.3, 0.55), random.Uniform(0.8, 2.0), random.Uniform(0.4, 0.95)};
    case 1:  // chest of drawers
      return {random.Uniform(0.35, 0.55), random.Uniform(0.4, 1.1), random.Uniform(0.5, 1.2)};
    case 2:  // wardrobe
      return {random.Uniform(0.4, 0.65), random.Uniform(0.5, 1.6), random.Uniform(1.5, 2.1)};
    default:  // bedside
      return {random.Uniform(0.32, 0.48), random.Uniform(0.32, 0.55), random.Uniform(0.35, 0.65)};
  }
}

}  // namespace

void BuildCabinet(Random& random, Solids& solids) {
  Case body;
  body.size = DrawCabinetSize(random);
  body.low = DrawFeet(random);
  const bool niche = Chance(random, 0.2) && body.size.z() > 0.5;
  if (!niche) {
    solids.Box(Material::kBody, {0, 0, body.MiddleZ()}, body.size);
    Front(random, body, solids);
  } else {  // the upper part stands open
    const double wall = random.Uniform(0.015, 0.03);
    Case lower = body;
    lower.size.z() *= random.Uniform(0.5, 0.75);
    solids.Box(Material::kBody, {0, 0, lower.MiddleZ()}, lower.size);
    Front(random, lower, solids);
    const double low = body.low + lower.size.z();
    const double high = body.low + body.size.z();
    for (const double side : kSides)
      solids.Box(Material::kBody,
                 {0, side * 0.5 * (body.size.y() - wall), 0.5 * (low + high)},
                 {body.size.x(), wall, high - low});
    solids.Box(Material::kBody,
               {-0.5 * (body.size.x() - wall), 0, 0.5 * (low + high)},
               {wall, body.size.y(), high - low});
    solids.Box(Material::kBody, {0, 0, high - 0.5 * wall}, {body.size.x(), body.size.y(), wall});
  }
  if (Chance(random, 0.4)) {  // top board, proud of the body
    const double over = random.Uniform(0.005, 0.03);
    solids.Box(Material::kTop,
               {0, 0, body.low + body.size.z() + 0.01},
               {body.size.x() + 2 * over, body.size.y() + 2 * over, 0.025});
  }
  if (body.low > 0)
    Feet(random, {body.size.head<2>(), body.low, random.Uniform(0.0, 0.05)}, solids);
}

}  // namespace deepslam::furniture
