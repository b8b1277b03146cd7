// Sofas that are cushions on a frame of wood or metal, open below: on legs, sledges, or frames at
// both ends that are legs and arms in one. The long side is along y.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct FramePlan {
  int places = 2;
  double width = 0;    // of the deck
  double depth = 0;    // of the deck
  double deck = 0;     // height of its upper side
  double rail = 0;     // thickness of the frame's parts
  double cushion = 0;  // thickness of the seat's
  double back_top = 0;
  double back = 0;  // thickness
  double lean = 0;  // of the back, backwards for each metre up

  [[nodiscard]] double seat() const { return deck + cushion; }
  [[nodiscard]] double rear() const { return -0.5 * depth; }
  // How far behind the deck's rear rim the back's front stands at a height.
  [[nodiscard]] double Behind(double z) const { return lean * (z - deck); }
};

FramePlan DrawFrame(Random& random) {
  FramePlan plan;
  plan.places = 1 + static_cast<int>(Pick(random, std::array{0.1, 1.0, 1.0, 0.15}));
  plan.width = plan.places * random.Uniform(0.5, 0.76);
  plan.depth = random.Uniform(0.52, 0.9);
  plan.cushion = random.Uniform(0.05, 0.22);
  plan.deck = std::max(0.12, random.Uniform(0.32, 0.48) - plan.cushion);
  plan.rail = random.Uniform(0.02, 0.06);
  plan.back_top = plan.seat() + random.Uniform(0.24, 0.55);
  plan.back = random.Uniform(0.05, 0.2);
  plan.lean = Chance(random, 0.3) ? 0.0 : random.Uniform(0.05, 0.4);
  return plan;
}

// What cushions lie on: a board, or rails round slats.
void Deck(Random& random, const FramePlan& plan, Solids& solids) {
  const double high = random.Uniform(0.02, 0.1);
  const double z = plan.deck - 0.5 * high;
  if (Chance(random, 0.4)) {
    solids.Box(Material::kFrame, {0, 0, z}, {plan.depth, plan.width, high});
    return;
  }
  for (const double side : kSides) {
    solids.Box(Material::kFrame,
               {side * 0.5 * (plan.depth - plan.rail), 0, z},
               {plan.rail, plan.width, high});
    solids.Box(Material::kFrame,
               {0, side * 0.5 * (plan.width - plan.rail), z},
               {plan.depth, plan.rail, high});
  }
  const int slats = Count(random, 2, 6);
  for (int n = 0; n < slats; ++n)
    solids.Box(Material::kFrame,
               {0, plan.width * ((n + 0.5) / slats - 0.5), plan.deck - 0.02},
               {plan.depth - 0.01, 0.05, 0.02});
}

void SeatCushions(Random& random, const FramePlan& plan, Solids& solids) {
  const int count = Chance(random, 0.35) ? 1 : plan.places;
  const double roundness = random.Uniform(0.05, 0.45);
  const double over = random.Uniform(-0.01, 0.04);  // beyond the deck's front
  const double width = plan.width / count;
  for (int n = 0; n < count; ++n)
    solids.Cushion(
        Material::kTop,
        {0.5 * over, width * (n + 0.5) - 0.5 * plan.width, plan.deck + 0.49 * plan.cushion},
        {plan.depth + over, width - 0.006, 1.02 * plan.cushion},
        roundness,
        0.12);
}

// Posts at both ends with bars or a board between them.
void BackFrame(Random& random, const FramePlan& plan, double top, Solids& solids) {
  const double low = plan.deck - 0.02;
  const auto at = [&](double z) { return plan.rear() + 0.5 * plan.rail - plan.Behind(z); };
  const double half = 0.5 * (plan.width - plan.rail);
  for (const double side : kSides)
    solids.Frustum(Material::kFrame,
                   {at(low), side * half, low},
                   {plan.rail, plan.rail},
                   {at(top), side * half, top},
                   {plan.rail, plan.rail});
  if (Chance(random, 0.35)) {
    solids.Board(
        Material::kFrame,
        [&](double u, double h) {
          const double z = plan.seat() + h * (top - plan.seat());
          return Eigen::Vector3d(at(z), u * half, z);
        },
        0.5 * plan.rail,
        5,
        3);
    return;
  }
  const int bars = Count(random, 1, 3);
  for (int n = 0; n < bars; ++n) {
    const double z = top - (top - plan.seat()) * n / bars - 0.5 * plan.rail;
    solids.Box(Material::kFrame, {at(z), 0, z}, {plan.rail, 2 * half, plan.rail});
  }
}

void BackCushions(Random& random, const FramePlan& plan, Solids& solids) {
  const int count = Chance(random, 0.35) ? 1 : plan.places;
  const double roundness = random.Uniform(0.05, 0.4);
  const double low = plan.seat() + random.Uniform(-0.06, 0.03);
  const double middle = 0.5 * (low + plan.back_top);
  const double width = plan.width / count;
  for (int n = 0; n < count; ++n)
    solids.Cushion(Material::kTop,
                   {plan.rear() + 0.4 * plan.rail + 0.5 * plan.back - plan.Behind(middle),
                    width * (n + 0.5) - 0.5 * plan.width,
                    middle},
                   {plan.back, width - 0.008, plan.back_top - low},
                   roundness,
                   0.15,
                   [&](const Eigen::Vector3d& p) {
                     return Eigen::Vector3d(p.x() - plan.lean * p.z(), p.y(), p.z());
                   });
}

struct ArmPlan {
  double low = 0;
  double top = 0;
  double front = 0;
  double rear = 0;
  double y = 0;
};

// A frame from floor to arm and down again, of tube or of flat bars; it carries the sofa.
void ArmFrame(Random& random, const ArmPlan& arm, double rail, Solids& solids) {
  const double splay = Chance(random, 0.3) ? random.Uniform(0.02, 0.1) : 0.0;
  const bool round = Chance(random, 0.5);
  const bool closed = Chance(random, 0.3);  // runs along the floor as well
  const double width = random.Uniform(0.03, 0.08);
  const double r = 0.5 * rail;
  for (const double side : kSides) {
    const double y = side * arm.y;
    if (round) {
      const double bend = random.Uniform(0.03, 0.1);
      solids.Tube(Material::kFrame,
                  {{arm.rear - splay, y, 0},
                   {arm.rear, y, arm.top - bend},
                   {arm.rear + bend, y, arm.top},
                   {arm.front - bend, y, arm.top},
                   {arm.front, y, arm.top - bend},
                   {arm.front + splay, y, 0}},
                  r,
                  r,
                  10);
    } else {
      for (const double end : kSides) {
        const double x = end > 0 ? arm.front : arm.rear;
        solids.Frustum(Material::kFrame,
                       {x + end * splay, y, 0},
                       {rail, width},
                       {x, y, arm.top},
                       {rail, width});
      }
      solids.Box(Material::kFrame,
                 {0.5 * (arm.front + arm.rear), y, arm.top},
                 {arm.front - arm.rear + rail, width, rail});
    }
    if (closed)
      solids.Box(Material::kFrame,
                 {0.5 * (arm.front + arm.rear), y, r},
                 {arm.front - arm.rear + 2 * splay, round ? rail : width, rail});
    // What the deck rests on.
    solids.Box(Material::kFrame,
               {0.5 * (arm.front + arm.rear), y - side * 0.01, arm.low},
               {arm.front - arm.rear, rail + 0.02, rail});
  }
}

// Panels or cushions between deck and arm.
void ArmPanels(Random& random, const ArmPlan& arm, double low, double thickness, Solids& solids) {
  const double roundness = Chance(random, 0.5) ? 0.05 : random.Uniform(0.1, 0.4);
  for (const double side : kSides)
    solids.Cushion(Material::kBody,
                   {0.5 * (arm.front + arm.rear), side * arm.y, 0.5 * (low + arm.top)},
                   {arm.front - arm.rear, thickness, arm.top - low},
                   roundness,
                   0.15);
}

enum class Ends : std::size_t { kOpen, kFrames, kFramesAndPanels, kPanels };

// Arms, and what carries the sofa.
void EndsOf(Random& random, const FramePlan& plan, Solids& solids) {
  const Ends ends = static_cast<Ends>(Pick(random, std::array{0.25, 0.25, 0.2, 0.3}));
  ArmPlan arm;
  arm.low = plan.deck - 0.5 * plan.rail - 0.01;
  arm.top = Chance(random, 0.25) ? plan.back_top : plan.seat() + random.Uniform(0.08, 0.28);
  arm.rear = plan.rear() + random.Uniform(-0.06, 0.08);
  arm.front = 0.5 * plan.depth - random.Uniform(-0.04, 0.14);
  arm.y = 0.5 * (plan.width + plan.rail) - 0.005;
  if (ends == Ends::kFrames || ends == Ends::kFramesAndPanels)
    ArmFrame(random, arm, plan.rail, solids);
  if (ends == Ends::kFramesAndPanels) {
    const double thickness = random.Uniform(0.03, 0.16);
    arm.y -= 0.45 * thickness;
    ArmPanels(random, arm, plan.deck - 0.01, thickness, solids);
  }
  if (ends == Ends::kPanels) {
    const double thickness = random.Uniform(0.05, 0.2);
    arm.y += 0.5 * thickness - plan.rail;
    ArmPanels(random, arm, plan.deck - random.Uniform(0.0, 0.1), thickness, solids);
  }
  if (ends == Ends::kOpen || ends == Ends::kPanels) {
    const Footing footing = {{plan.depth, plan.width}, plan.deck - 0.01, random.Uniform(0.0, 0.12)};
    if (Chance(random, 0.8)) {
      FourLegs(random, footing, solids);
    } else {
      Sledges(random, footing, solids);
    }
  }
}

}  // namespace

void BuildFramedSofa(Random& random, Solids& solids) {
  const FramePlan plan = DrawFrame(random);
  Deck(random, plan, solids);
  SeatCushions(random, plan, solids);
  const bool cushions = Chance(random, 0.85);
  const double frame_top =
      cushions ? plan.seat() + random.Uniform(0.5, 1.05) * (plan.back_top - plan.seat())
               : plan.back_top;
  BackFrame(random, plan, frame_top, solids);
  if (cushions) BackCushions(random, plan, solids);
  EndsOf(random, plan, solids);
}

}  // namespace deepslam::furniture
