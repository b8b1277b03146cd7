// Settees and benches with a back: a wide seat on a frame of wood or metal. The long side is along
// y.
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/seats.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

Seat DrawBench(Random& random) {
  Seat seat;
  seat.width = random.Uniform(0.95, 2.1);
  seat.depth = random.Uniform(0.42, 0.85);
  seat.height = random.Uniform(0.34, 0.47);
  seat.thickness = random.Uniform(0.02, 0.09);
  return seat;
}

struct SidePanels {
  double thickness = 0;
  double low = 0;
  double top = 0;
};

// Panels at both sides, which are arms and may carry the seat.
void Sides(const SidePanels& panels, const Seat& seat, Solids& solids) {
  for (const double side : kSides)
    solids.Box(Material::kFrame,
               {-0.02,
                side * 0.5 * (seat.width + 0.9 * panels.thickness),
                0.5 * (panels.low + panels.top)},
               {seat.depth + 0.04, panels.thickness, panels.top - panels.low});
}

void FlatBack(Random& random, const Seat& seat, double high, Solids& solids) {
  const double thickness = random.Uniform(0.02, 0.09);
  const double low = Chance(random, 0.5) ? seat.height - seat.thickness : 0.4 * seat.height;
  solids.Box(Material::kBody,
             {-0.5 * seat.depth - 0.4 * thickness, 0, 0.5 * (low + high)},
             {thickness, seat.width + 0.01, high - low});
}

void BenchCushions(Random& random, const Seat& seat, double back_top, Solids& solids) {
  const int places = Count(random, 1, 3);
  const double thickness = random.Uniform(0.06, 0.16);
  const double width = seat.width / places;
  const bool behind = Chance(random, 0.5);
  for (int n = 0; n < places; ++n) {
    const double y = width * (n + 0.5) - 0.5 * seat.width;
    solids.Cushion(Material::kTop,
                   {0.01, y, seat.height + 0.45 * thickness},
                   {seat.depth, width - 0.01, thickness},
                   0.3,
                   0.15);
    if (!behind) continue;
    const double low = seat.height + 0.7 * thickness;
    solids.Cushion(Material::kTop,
                   {-0.5 * seat.depth + 0.06, y, 0.5 * (low + back_top)},
                   {0.16, width - 0.02, back_top - low},
                   0.35,
                   0.2);
  }
}

}  // namespace

void BuildSettee(Random& random, Solids& solids) {
  Seat seat = DrawBench(random);
  const bool flat = Chance(random, 0.5);
  const double back_top = seat.height + random.Uniform(0.28, 0.55);
  if (flat) {
    solids.Box(Material::kTop,
               {0, 0, seat.height - 0.5 * seat.thickness},
               {seat.depth, seat.width, seat.thickness});
    FlatBack(random, seat, back_top, solids);
  } else {
    SeatBoard(random, seat, solids);
    SeatBack(random, seat, false, solids);
  }
  const std::size_t arms = Pick(random, std::array{0.25, 0.4, 0.35});
  const bool carried = arms == 1 && Chance(random, 0.5);
  if (arms == 1) {
    const double top = Chance(random, 0.4) ? back_top : seat.height + random.Uniform(0.08, 0.26);
    const double low = carried ? 0.0 : seat.height - seat.thickness;
    Sides({random.Uniform(0.02, 0.14), low, top}, seat, solids);
  } else if (arms == 2) {
    SeatArms(random, seat, 0.1, solids);
  }
  const double underside = seat.height - seat.thickness + 0.008;
  if (!carried) {
    FourLegs(random,
             {seat.corner * Eigen::Vector2d(seat.depth, seat.width),
              underside,
              random.Uniform(0.0, 0.06)},
             solids);
  }
  if (flat && Chance(random, 0.45)) BenchCushions(random, seat, back_top - 0.04, solids);
}

}  // namespace deepslam::furniture
