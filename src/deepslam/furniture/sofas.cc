// Upholstered sofas, straight and round a corner. The long side is along y.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct SofaPlan {
  double width = 0;  // between the arms
  double depth = 0;  // with the back
  double seat = 0;   // height
  double feet = 0;
  double arm = 0;
  double arm_height = 0;
  double back = 0;
  double back_height = 0;
  int places = 2;
};

SofaPlan DrawSofa(Random& random) {
  SofaPlan plan;
  plan.places = 1 + static_cast<int>(Pick(random, std::array{0.12, 1.0, 1.0, 0.35}));
  plan.width = plan.places * random.Uniform(0.54, 0.72);
  plan.depth = random.Uniform(0.75, 1.02);
  plan.seat = random.Uniform(0.36, 0.48);
  plan.feet = random.Uniform(0.02, Chance(random, 0.2) ? 0.26 : 0.17);
  plan.arm = Chance(random, 0.15) ? 0.0 : random.Uniform(0.07, 0.26);
  plan.arm_height = plan.seat + random.Uniform(0.06, 0.26);
  plan.back = random.Uniform(0.12, 0.26);
  plan.back_height = plan.seat + random.Uniform(0.26, 0.52);
  return plan;
}

void SofaArms(Random& random, const SofaPlan& plan, Solids& solids) {
  if (plan.arm <= 0) return;
  const std::size_t kind = Pick(random, std::array{1.0, 0.8, 0.5});
  const double height = plan.arm_height - plan.feet;
  for (const double side : kSides) {
    const Eigen::Vector3d middle(0, side * 0.5 * (plan.width + plan.arm), plan.feet + 0.5 * height);
    const Eigen::Vector3d size(plan.depth, plan.arm, height);
    if (kind == 0) {
      solids.Box(Material::kBody, middle, size);
    } else if (kind == 1) {
      solids.Cushion(Material::kBody, middle, size, random.Uniform(0.15, 0.35), 0.15);
    } else {  // rolled
      const double r = 0.6 * plan.arm;
      solids.Box(Material::kBody, middle, {size.x(), 0.8 * size.y(), size.z()});
      solids.Tube(Material::kBody,
                  {{-0.5 * plan.depth, middle.y(), plan.arm_height - 0.5 * r},
                   {0.5 * plan.depth, middle.y(), plan.arm_height - 0.5 * r}},
                  r,
                  r,
                  14);
    }
  }
}

void SeatCushions(
    Random& random, const SofaPlan& plan, double chaise, double chaise_side, Solids& solids) {
  const double thickness = random.Uniform(0.1, 0.2);
  const double roundness = random.Uniform(0.2, 0.45);
  const bool one = Chance(random, 0.25);
  const int count = one ? 1 : plan.places;
  const double width = plan.width / count;
  const double back_x = -0.5 * plan.depth + plan.back;
  const double lean = random.Uniform(0.0, 0.3);
  const double back_cushion = random.Uniform(0.1, 0.2);
  const bool cushions_behind = Chance(random, 0.7);
  for (int n = 0; n < count; ++n) {
    const double y = -0.5 * plan.width + width * (n + 0.5);
    const bool long_one = chaise > 0 && n == (chaise_side > 0 ? count - 1 : 0);
    const double front = 0.5 * plan.depth + (long_one ? chaise : 0.0) + 0.015;
    solids.Cushion(Material::kTop,
                   {0.5 * (back_x + front), y, plan.seat - 0.5 * thickness},
                   {front - back_x, width - 0.008, thickness},
                   roundness,
                   0.15);
    if (!cushions_behind) continue;
    const double height = plan.back_height - plan.seat + random.Uniform(-0.04, 0.06);
    solids.Cushion(Material::kTop,
                   {back_x + 0.4 * back_cushion, y, plan.seat + 0.5 * height - 0.02},
                   {back_cushion, width - 0.012, height},
                   roundness,
                   0.2,
                   Leaning(lean));
  }
}

// Back along the y side: upright or leaning, straight, rounded above, or a wedge that is thick
// below.
void SofaBack(Random& random, const SofaPlan& plan, double from_y, double to_y, Solids& solids) {
  const double low = plan.feet + 0.01;
  const double middle_y = 0.5 * (from_y + to_y);
  if (Chance(random, 0.2)) {
    const double above = plan.back * random.Uniform(0.35, 0.8);
    const double below = plan.back * random.Uniform(1.1, 1.9);
    solids.Frustum(Material::kBody,
                   {-0.5 * plan.depth + 0.5 * below, middle_y, low},
                   {below, to_y - from_y},
                   {-0.5 * plan.depth + 0.5 * above, middle_y, plan.back_height},
                   {above, to_y - from_y});
    return;
  }
  const double lean = Chance(random, 0.5) ? random.Uniform(0.0, 0.25) : 0.0;
  const double roundness = Chance(random, 0.5) ? 0.05 : random.Uniform(0.15, 0.4);
  solids.Cushion(Material::kBody,
                 {-0.5 * plan.depth + 0.5 * plan.back, middle_y, 0.5 * (low + plan.back_height)},
                 {plan.back, to_y - from_y, plan.back_height - low},
                 roundness,
                 0.12,
                 Leaning(lean));
}

// Loose ones, leaning against the back.
void Pillows(Random& random, const SofaPlan& plan, Solids& solids) {
  if (!Chance(random, 0.35)) return;
  const int count = Count(random, 1, 4);
  for (int n = 0; n < count; ++n) {
    const double side = random.Uniform(0.28, 0.5);
    const double turn = random.Uniform(-0.5, 0.5);
    const double lean = random.Uniform(0.2, 0.7);
    solids.Cushion(Material::kDetail,
                   {-0.5 * plan.depth + plan.back + random.Uniform(0.12, 0.25),
                    0.45 * plan.width * random.Uniform(-1.0, 1.0),
                    plan.seat + 0.42 * side},
                   {random.Uniform(0.1, 0.18), side, side},
                   0.6,
                   0.6,
                   [&](const Eigen::Vector3d& p) {
                     return Eigen::Vector3d(
                         p.x() - lean * p.z() + turn * p.y(), p.y() - turn * p.x(), p.z());
                   });
  }
}

// The wing of a corner sofa: from the main seat's end forward, its back along the end.
struct Wing {
  double side = 1;     // of y
  double forward = 0;  // beyond the main seat
  double width = 0;    // along y
};

void WingOf(Random& random, const SofaPlan& plan, const Wing& wing, Solids& solids) {
  const double total = plan.width + 2 * plan.arm;
  const double low = plan.feet + 0.01;
  const double box_top = plan.seat - 0.06;
  const double outer = wing.side * 0.5 * total;
  const double front = 0.5 * plan.depth + wing.forward;
  const double back_x = -0.5 * plan.depth;
  const double middle_y = outer - wing.side * 0.5 * wing.width;
  solids.Box(Material::kBody,
             {0.5 * (back_x + front), middle_y, 0.5 * (low + box_top)},
             {front - back_x - 0.02, wing.width - 0.02, box_top - low});
  solids.Cushion(
      Material::kBody,
      {0.5 * (back_x + front), outer - wing.side * 0.5 * plan.back, 0.5 * (low + plan.back_height)},
      {front - back_x, plan.back, plan.back_height - low},
      random.Uniform(0.05, 0.3),
      0.1);
  const int cushions = Count(random, 1, 2);
  const double thickness = random.Uniform(0.1, 0.2);
  const double length = wing.forward + 0.02;
  for (int n = 0; n < cushions; ++n)
    solids.Cushion(Material::kTop,
                   {0.5 * plan.depth + length * (n + 0.5) / cushions,
                    middle_y - wing.side * 0.5 * plan.back,
                    plan.seat - 0.5 * thickness},
                   {length / cushions, wing.width - plan.back, thickness},
                   0.3,
                   0.15);
  if (Chance(random, 0.5))
    solids.Box(Material::kBody,
               {front + 0.5 * plan.arm - 0.01, middle_y, 0.5 * (low + plan.arm_height)},
               {plan.arm + 0.05, wing.width, plan.arm_height - low});
  for (const double end : kSides)
    solids.Box(Material::kFrame,
               {front - 0.1, middle_y + 0.4 * end * wing.width, 0.5 * plan.feet},
               {0.05, 0.05, plan.feet + 0.03});
}

// Longer part of a straight sofa's seat.
void Chaise(const SofaPlan& plan, double forward, double side, Solids& solids) {
  const double box_top = plan.seat - 0.06;
  const double width = plan.width / plan.places;
  const double y = side * (0.5 * plan.width - 0.5 * width);
  solids.Box(Material::kBody,
             {0.5 * plan.depth + 0.5 * forward - 0.02, y, 0.5 * (plan.feet + box_top)},
             {forward, width, box_top - plan.feet});
  for (const double end : kSides)
    solids.Box(Material::kFrame,
               {0.5 * plan.depth + forward - 0.09, y + 0.4 * end * width, 0.5 * plan.feet},
               {0.05, 0.05, plan.feet + 0.01});
}

void MainSeat(const SofaPlan& plan, Solids& solids) {
  const double total = plan.width + 2 * plan.arm;
  const double box_top = plan.seat - 0.06;
  solids.Box(Material::kBody,
             {0, 0, 0.5 * (plan.feet + box_top)},
             {plan.depth - 0.02, total - 0.02, box_top - plan.feet});
}

}  // namespace

void BuildSofa(Random& random, Solids& solids) {
  const SofaPlan plan = DrawSofa(random);
  const double total = plan.width + 2 * plan.arm;
  MainSeat(plan, solids);
  const double chaise = plan.places >= 2 && Chance(random, 0.15) ? random.Uniform(0.35, 0.95) : 0.0;
  const double side = Chance(random, 0.5) ? 1.0 : -1.0;
  if (chaise > 0) Chaise(plan, chaise, side, solids);
  const double half_back = 0.5 * (Chance(random, 0.6) ? total : plan.width);
  SofaBack(random, plan, -half_back, half_back, solids);
  SofaArms(random, plan, solids);
  SeatCushions(random, plan, chaise, side, solids);
  Pillows(random, plan, solids);
  Feet(random, {{plan.depth, total}, plan.feet, random.Uniform(0.02, 0.08)}, solids);
}

void BuildCornerSofa(Random& random, Solids& solids) {
  SofaPlan plan = DrawSofa(random);
  plan.places = Count(random, 2, 4);
  plan.width = plan.places * random.Uniform(0.56, 0.7);
  plan.arm = std::max(plan.arm, 0.05);
  const double total = plan.width + 2 * plan.arm;
  Wing wing;
  wing.side = Chance(random, 0.5) ? 1.0 : -1.0;
  wing.width = plan.depth * random.Uniform(0.8, 1.05);
  wing.forward = random.Uniform(0.35, 0.95 * total - plan.depth);
  MainSeat(plan, solids);
  SofaBack(random, plan, -0.5 * total, 0.5 * total, solids);
  WingOf(random, plan, wing, solids);
  // The arm at the open end.
  if (Chance(random, 0.7))
    solids.Box(Material::kBody,
               {0, -wing.side * 0.5 * (plan.width + plan.arm), 0.5 * (plan.feet + plan.arm_height)},
               {plan.depth, plan.arm, plan.arm_height - plan.feet});
  SeatCushions(random, plan, 0, wing.side, solids);
  Pillows(random, plan, solids);
  Feet(random, {{plan.depth, total}, plan.feet, random.Uniform(0.02, 0.08)}, solids);
}

}  // namespace deepslam::furniture
