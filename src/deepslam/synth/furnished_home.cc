#include "deepslam/synth/furnished_home.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "deepslam/core/angles.h"
#include "deepslam/core/random.h"
#include "deepslam/synth/home_plan.h"
#include "deepslam/synth/home_walk.h"

namespace deepslam::synth {
namespace {

// What a piece is called in the truth, a class of the table, and the catalogue's pieces of its
// kind.
struct Kind {
  std::string_view class_name;
  std::span<const std::string_view> models;
};

constexpr std::array<std::string_view, 7> kSofas = {"Blend Swap CC-0#sofa2",
                                                    "Blend Swap CC-BY#sofa2",
                                                    "Scopia#simple_sofa",
                                                    "Scopia#clear_sofa",
                                                    "Scopia#leather_sofa",
                                                    "Kator Legaz#mid-century-sofa",
                                                    "Blend Swap CC-0#winchesterSofa"};
constexpr std::array<std::string_view, 4> kArmchairs = {"Scopia#armchair2",
                                                        "Blend Swap CC-0#modernArmchair",
                                                        "Scopia#armchair",
                                                        "Blend Swap CC-BY#armchair1"};
constexpr std::array<std::string_view, 5> kCoffeeTables = {"Scopia#coffee_table",
                                                           "Scopia#saloon_table",
                                                           "Scopia#coffee-table2",
                                                           "Scopia#table_wood_and_iron",
                                                           "Blend Swap CC-BY#coffeeTable"};
constexpr std::array<std::string_view, 6> kTables = {"Scopia#table-with-leaning-feet",
                                                     "Blend Swap CC-BY#table",
                                                     "Scopia#table4",
                                                     "Scopia#wooden_table_office",
                                                     "Scopia#black_table",
                                                     "Blend Swap CC-0#oakTable"};
constexpr std::array<std::string_view, 10> kChairs = {"Blend Swap CC-0#chairWithCushion",
                                                      "Blend Swap CC-0#oakChair",
                                                      "Scopia#chair",
                                                      "Blend Swap CC-0#chair2",
                                                      "Blend Swap CC-BY#chair3",
                                                      "Blend Swap CC-BY#kitchenChair",
                                                      "Kator Legaz#dining-chair",
                                                      "Scopia#white_kitchen_chair",
                                                      "Scopia#chair3",
                                                      "Blend Swap CC-0#chair"};
constexpr std::array<std::string_view, 4> kBookcases = {"Blend Swap CC-0#bookcase",
                                                        "Kator Legaz#full-bookcase",
                                                        "Blend Swap CC-BY#bookcase",
                                                        "Scopia#dining_room"};
constexpr std::array<std::string_view, 3> kDressers = {
    "Blend Swap CC-BY#dresserWithDrawers", "Blend Swap CC-BY#tvStand", "Blend Swap CC-BY#chest"};
constexpr std::array<std::string_view, 2> kTvs = {"Blend Swap CC-0#led_tv", "Scopia#tv"};
constexpr std::array<std::string_view, 4> kPlants = {"Blend Swap CC-0#decorativePlant",
                                                     "Blend Swap CC-BY#spatifilum",
                                                     "Scopia#ficus",
                                                     "Blend Swap CC-0#plant"};
constexpr std::array<std::string_view, 5> kBeds = {"Blend Swap CC-0#bed1",
                                                   "Blend Swap CC-0#bed2",
                                                   "Scopia#bed1",
                                                   "Scopia#iron_bed",
                                                   "Blend Swap CC-BY#juniorBed"};
constexpr std::array<std::string_view, 2> kNightstands = {"Blend Swap CC-0#bedsideTable2",
                                                          "Blend Swap CC-BY#bedsideTable"};
constexpr std::array<std::string_view, 4> kWardrobes = {"Blend Swap CC-BY#wardrobe",
                                                        "Blend Swap CC-BY#wardrobe2",
                                                        "Scopia#wardrobe1",
                                                        "Blend Swap CC-0#cupboard"};
constexpr std::array<std::string_view, 3> kDesks = {
    "Scopia#kids_wooden_desk", "Scopia#table-on-trestles", "Scopia#white_kitchen_table"};
constexpr std::array<std::string_view, 3> kCounters = {"Blend Swap CC-0#lowerCabinet",
                                                       "Blend Swap CC-0#drawersCabinet",
                                                       "Blend Swap CC-BY#kitchenDrawersCabinet"};
constexpr std::array<std::string_view, 2> kSinks = {"Blend Swap CC-0#sinkCabinet",
                                                    "Blend Swap CC-BY#kitchenSink"};
constexpr std::array<std::string_view, 2> kWallCabinets = {"Blend Swap CC-0#upperCabinet",
                                                           "Blend Swap CC-0#glassDoorCabinet"};
constexpr std::array<std::string_view, 2> kFridges = {"Kator Legaz#fridge",
                                                      "Blend Swap CC-0#largeFridge"};
constexpr std::array<std::string_view, 1> kMicrowaves = {"Blend Swap CC-BY#microwave"};
constexpr std::array<std::string_view, 3> kStools = {
    "Blend Swap CC-BY#green_stool", "Blend Swap CC-0#stool2", "Blend Swap CC-0#silla2"};
constexpr std::array<std::string_view, 3> kToilets = {"Blend Swap CC-0#toiletsUnit",
                                                      "Blend Swap CC-BY#toilets_unit_jay_hardy",
                                                      "Blend Swap CC-BY#modernToilet"};
constexpr std::array<std::string_view, 2> kBasins = {"Blend Swap CC-0#washbasin",
                                                     "Blend Swap CC-BY#washbasin_jay_hardy"};
constexpr std::array<std::string_view, 1> kWashers = {"Blend Swap CC-BY#washing_machine"};

constexpr Kind kSofa = {"sofa", kSofas}, kArmchair = {"chair", kArmchairs},
               kCoffeeTable = {"table", kCoffeeTables}, kTable = {"table", kTables},
               kChair = {"chair", kChairs}, kBookcase = {"shelf", kBookcases},
               kDresser = {"cabinet", kDressers}, kTv = {"tv", kTvs}, kPlant = {"plant", kPlants},
               kBed = {"bed", kBeds}, kNightstand = {"cabinet", kNightstands},
               kWardrobe = {"cabinet", kWardrobes}, kDesk = {"table", kDesks},
               kCounter = {"cabinet", kCounters}, kSink = {"sink", kSinks},
               kWallCabinet = {"cabinet", kWallCabinets}, kFridge = {"refrigerator", kFridges},
               kMicrowave = {"microwave", kMicrowaves}, kStool = {"chair", kStools},
               kToilet = {"toilet", kToilets}, kBasin = {"sink", kBasins},
               kWasher = {"furniture", kWashers};
constexpr std::array<Kind, 22> kKinds = {
    kSofa,   kArmchair,  kCoffeeTable, kTable,    kChair, kBookcase, kDresser, kTv,
    kPlant,  kBed,       kNightstand,  kWardrobe, kDesk,  kCounter,  kSink,    kWallCabinet,
    kFridge, kMicrowave, kStool,       kToilet,   kBasin, kWasher};

constexpr double kGapToWall_m = 0.02;   // skirting boards keep things off walls
constexpr double kGapBetween_m = 0.03;  // neighbours are not to meet
constexpr double kDoorReach_m = 0.9;  // free before a door, to both sides
constexpr double kHigh_m = 0.9;       // what is higher does not stand before a window
constexpr double kWalkway_m = 0.65;   // free around what stands in the middle of a room
constexpr double kWallCabinet_m = 1.45;  // its bottom: half a metre above a counter
constexpr int kTries = 40;  // for a place

struct Piece {
  std::string class_name;
  std::string model;
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
};

struct Wall {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // where it begins
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();
  Eigen::Vector2d inward = Eigen::Vector2d::UnitY();
  double length_m = 0;
};

std::array<Wall, 4> WallsOf(const FloorRectangle& room) {
  const Eigen::Vector2d size = room.size();
  return {{{room.min, {1, 0}, {0, 1}, size.x()},
           {{room.max.x(), room.min.y()}, {0, 1}, {-1, 0}, size.y()},
           {room.max, {-1, 0}, {0, -1}, size.x()},
           {{room.min.x(), room.max.y()}, {0, -1}, {1, 0}, size.y()}}};
}

class Furnisher {
 public:
  Furnisher(const HomePlan& plan, const PieceSizes& sizes, Random& random, SceneDescription& scene)
      : plan_(plan), sizes_(sizes), random_(random), scene_(scene) {
    for (const PlannedDoor& door : plan.doors) {
      const Eigen::Vector2d reach =
          door.through.cwiseAbs() * kDoorReach_m +
          0.5 * Eigen::Vector2d(door.through.y(), door.through.x()).cwiseAbs();
      kept_free_.push_back({door.middle_m - reach, door.middle_m + reach});
    }
  }

  void Furnish() {
    for (const PlannedRoom& room : plan_.rooms) {
      room_ = &room;
      switch (room.use) {
        case RoomUse::kLiving:
          FurnishLiving();
          break;
        case RoomUse::kKitchen:
          FurnishKitchen();
          break;
        case RoomUse::kBedroom:
          FurnishBedroom();
          break;
        case RoomUse::kBath:
          FurnishBath();
          break;
      }
    }
  }

  // What a walk has to go round.
  [[nodiscard]] const std::vector<FloorRectangle>& taken() const { return taken_; }

 private:
  struct Placed {
    Piece piece;
    Eigen::Vector2d middle_m;
    Eigen::Vector2d front;
  };

  std::optional<Piece> Draw(const Kind& kind) {
    std::vector<std::string_view> there;
    for (const std::string_view model : kind.models) {
      if (sizes_.contains(std::string(model))) there.push_back(model);
    }
    if (there.empty()) return std::nullopt;
    const std::string model(there[random_.Index(there.size())]);
    return Piece{std::string(kind.class_name), model, sizes_.at(model)};
  }

  static FloorRectangle FootprintOf(const Piece& piece,
                                    const Eigen::Vector2d& middle,
                                    const Eigen::Vector2d& front) {
    const Eigen::Vector2d side(-front.y(), front.x());
    const Eigen::Vector2d half =
        0.5 * (piece.size_m.x() * front.cwiseAbs() + piece.size_m.y() * side.cwiseAbs());
    return {middle - half, middle + half};
  }

  [[nodiscard]] bool IsFree(const FloorRectangle& place, double height_m, double margin_m) const {
    if (!room_->floor.Contains(place)) return false;
    const auto meets = [&](const FloorRectangle& other) { return place.Overlaps(other, margin_m); };
    if (std::ranges::any_of(taken_, meets)) return false;
    if (std::ranges::any_of(kept_free_, [&](const auto& door) { return place.Overlaps(door); }))
      return false;
    return std::ranges::none_of(plan_.windows, [&](const PlannedWindow& window) {
      const bool is_door = window.reach.size().minCoeff() > 0.9;  // the closed one: as other doors
      return (is_door || height_m > kHigh_m) && place.Overlaps(window.reach);
    });
  }

  // In the room, and among what stands there with that many alone: what it is pushed under.
  [[nodiscard]] bool MeetsNothingBut(int count, const FloorRectangle& place) const {
    return room_->floor.Contains(place) &&
           std::ranges::count_if(
               taken_, [&](const FloorRectangle& other) { return place.Overlaps(other); }) <= count;
  }

  void Stand(const Piece& piece,
             const Eigen::Vector2d& middle,
             const Eigen::Vector2d& front,
             double bottom_m = 0) {
    SceneObject object;
    object.class_name = piece.class_name;
    object.model = piece.model;
    object.position_m = middle;
    object.bottom_m = bottom_m;
    object.yaw_deg = std::atan2(front.y(), front.x()) * kDegPerRad;
    scene_.objects.push_back(object);
    if (bottom_m == 0) taken_.push_back(FootprintOf(piece, middle, front));
  }

  // With its back to a wall, somewhere along it.
  std::optional<Placed> AgainstWall(const Kind& kind) {
    const std::optional<Piece> piece = Draw(kind);
    if (!piece) return std::nullopt;
    for (int n = 0; n < kTries; ++n) {
      const Wall wall = WallsOf(room_->floor)[random_.Index(4)];
      const double room_m = wall.length_m - piece->size_m.y() - 2 * kGapToWall_m;
      if (room_m < 0) continue;
      // Half of all things stand in a corner.
      const double share = std::clamp(random_.Uniform(-0.5, 1.5), 0.0, 1.0);
      const double along_m = kGapToWall_m + share * room_m + piece->size_m.y() / 2;
      const Placed placed = {
          *piece,
          wall.corner + along_m * wall.along + (kGapToWall_m + piece->size_m.x() / 2) * wall.inward,
          wall.inward};
      if (!IsFree(
              FootprintOf(*piece, placed.middle_m, placed.front), piece->size_m.z(), kGapBetween_m))
        continue;
      Stand(*piece, placed.middle_m, placed.front);
      return placed;
    }
    return std::nullopt;
  }

  // On what was placed, as a lamp stands on a table.
  void On(const std::optional<Placed>& carrier, const Kind& kind) {
    const std::optional<Piece> piece = Draw(kind);
    if (!carrier || !piece) return;
    if (piece->size_m.x() > carrier->piece.size_m.x() ||
        piece->size_m.y() > carrier->piece.size_m.y())
      return;
    Stand(*piece, carrier->middle_m, carrier->front, carrier->piece.size_m.z() + 0.002);
  }

  // Right beside what stands against a wall.
  void Beside(const std::optional<Placed>& other, const Kind& kind, double side) {
    const std::optional<Piece> piece = Draw(kind);
    if (!other || !piece) return;
    const Eigen::Vector2d along(-other->front.y(), other->front.x());
    const double aside_m =
        (other->piece.size_m.y() + piece->size_m.y()) / 2 + kGapBetween_m + 0.001;
    const Eigen::Vector2d back =
        0.5 * (other->piece.size_m.x() - piece->size_m.x()) * -other->front;
    const Eigen::Vector2d middle = other->middle_m + side * aside_m * along + back;
    if (IsFree(FootprintOf(*piece, middle, other->front), piece->size_m.z(), 0))
      Stand(*piece, middle, other->front);
  }

  std::optional<Placed> InTheMiddle(const Kind& kind, double walkway_m) {
    const std::optional<Piece> piece = Draw(kind);
    if (!piece) return std::nullopt;
    const Eigen::Vector2d size = room_->floor.size();
    for (int n = 0; n < kTries; ++n) {
      const bool turned = (size.x() > size.y()) == (piece->size_m.y() < piece->size_m.x());
      const Eigen::Vector2d front = turned ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
      const Eigen::Vector2d middle =
          room_->floor.middle() +
          0.25 * size.cwiseProduct(Eigen::Vector2d(random_.Uniform(-1, 1), random_.Uniform(-1, 1)));
      FloorRectangle place = FootprintOf(*piece, middle, front);
      place.min.array() -= walkway_m;
      place.max.array() += walkway_m;
      if (!IsFree(place, 0, 0)) continue;
      Stand(*piece, middle, front);
      return Placed{*piece, middle, front};
    }
    return std::nullopt;
  }

  // Chairs of one kind along all sides, pushed under by half of their seats.
  void ChairsAround(const std::optional<Placed>& table) {
    const std::optional<Piece> chair = Draw(kChair);
    if (!table || !chair) return;
    const Eigen::Vector2d side(-table->front.y(), table->front.x());
    const double width_m = chair->size_m.y() + 0.08;
    for (const auto& [outward, depth_m, length_m] :
         {std::tuple(table->front, table->piece.size_m.x(), table->piece.size_m.y()),
          std::tuple(
              Eigen::Vector2d(-table->front), table->piece.size_m.x(), table->piece.size_m.y()),
          std::tuple(side, table->piece.size_m.y(), table->piece.size_m.x()),
          std::tuple(Eigen::Vector2d(-side), table->piece.size_m.y(), table->piece.size_m.x())}) {
      const int count = std::min(2, static_cast<int>((length_m - 0.1) / width_m));
      for (int n = 0; n < count; ++n) {
        if (random_.Uniform() < 0.2) continue;
        const Eigen::Vector2d along(-outward.y(), outward.x());
        const double aside_m = (n - 0.5 * (count - 1)) * (length_m / count);
        const double pushed_m = random_.Uniform(0.1, 0.5) * chair->size_m.x();
        const Eigen::Vector2d middle = table->middle_m + aside_m * along +
                                       ((depth_m + chair->size_m.x()) / 2 - pushed_m) * outward;
        if (room_->floor.Contains(FootprintOf(*chair, middle, outward)))
          Stand(*chair, middle, Eigen::Vector2d(-outward));
      }
    }
  }

  void FurnishLiving() {
    const std::optional<Placed> table = InTheMiddle(kTable, kWalkway_m + 0.45);
    ChairsAround(table);
    const std::optional<Placed> sofa = AgainstWall(kSofa);
    if (sofa) {
      const std::optional<Piece> low = Draw(kCoffeeTable);
      if (low) {
        const Eigen::Vector2d middle =
            sofa->middle_m + ((sofa->piece.size_m.x() + low->size_m.x()) / 2 + 0.35) * sofa->front;
        if (IsFree(FootprintOf(*low, middle, sofa->front), low->size_m.z(), kGapBetween_m))
          Stand(*low, middle, sofa->front);
      }
    }
    On(AgainstWall(kDresser), kTv);
    AgainstWall(kBookcase);
    AgainstWall(kArmchair);
    AgainstWall(kPlant);
  }

  void FurnishKitchen() {
    // A row: from a fridge on, as far as the wall is free.
    const std::optional<Placed> fridge = AgainstWall(kFridge);
    for (const double side : {1.0, -1.0}) {
      if (!fridge) break;
      Placed last = *fridge;
      const std::array<Kind, 4> row = {kCounter, kSink, kCounter, kCounter};
      for (const Kind& kind : row) {
        const std::size_t before = taken_.size();
        Beside(last, kind, side);
        if (taken_.size() == before) break;
        const SceneObject& placed = scene_.objects.back();
        last = {{placed.class_name, placed.model, sizes_.at(placed.model)},
                placed.position_m,
                fridge->front};
        if (kind.class_name == "sink") continue;
        if (random_.Uniform() < 0.3)
          On(last, kMicrowave);
        else
          Above(last);
      }
    }
    const std::optional<Placed> table = InTheMiddle(kTable, kWalkway_m + 0.3);
    ChairsAround(table);
    AgainstWall(kStool);
    AgainstWall(kPlant);
  }

  // A wall cabinet over a counter, but not before a window.
  void Above(const Placed& counter) {
    const std::optional<Piece> piece = Draw(kWallCabinet);
    if (!piece || kWallCabinet_m + piece->size_m.z() > plan_.size_m.z()) return;
    const Eigen::Vector2d middle =
        counter.middle_m - 0.5 * (counter.piece.size_m.x() - piece->size_m.x()) * counter.front;
    const FloorRectangle place = FootprintOf(*piece, middle, counter.front);
    if (!room_->floor.Contains(place)) return;
    const bool before_window = std::ranges::any_of(
        plan_.windows, [&](const PlannedWindow& window) { return place.Overlaps(window.reach); });
    const bool meets = std::ranges::any_of(
        hanging_, [&](const FloorRectangle& other) { return place.Overlaps(other); });
    if (before_window || meets) return;
    Stand(*piece, middle, counter.front, kWallCabinet_m);
    hanging_.push_back(place);
  }

  void FurnishBedroom() {
    const std::optional<Placed> bed = AgainstWall(kBed);
    Beside(bed, kNightstand, 1);
    Beside(bed, kNightstand, -1);
    AgainstWall(kWardrobe);
    const std::optional<Placed> desk = AgainstWall(kDesk);
    if (desk) {
      const std::optional<Piece> chair = Draw(kChair);
      const double away_m = chair ? (desk->piece.size_m.x() + 0.6 * chair->size_m.x()) / 2 : 0;
      const Eigen::Vector2d middle = desk->middle_m + away_m * desk->front;
      if (chair && MeetsNothingBut(1, FootprintOf(*chair, middle, desk->front)))
        Stand(*chair, middle, Eigen::Vector2d(-desk->front));
    }
    AgainstWall(kDresser);
    AgainstWall(kPlant);
  }

  void FurnishBath() {
    AgainstWall(kToilet);
    AgainstWall(kBasin);
    AgainstWall(kWasher);
  }

  const HomePlan& plan_;
  const PieceSizes& sizes_;
  Random& random_;
  SceneDescription& scene_;
  const PlannedRoom* room_ = nullptr;
  std::vector<FloorRectangle> taken_;
  std::vector<FloorRectangle> kept_free_;
  std::vector<FloorRectangle> hanging_;
};

void Light(const HomePlan& plan, SceneDescription& scene) {
  for (const PlannedRoom& room : plan.rooms) {
    SceneLight light;
    light.position_m = {room.floor.middle().x(), room.floor.middle().y(), plan.size_m.z() - 0.05};
    light.side_m = 0.8;
    light.power = 2.2;
    scene.lights.push_back(light);
  }
}

}  // namespace

std::vector<std::string> HomePieces() {
  std::vector<std::string> pieces;
  for (const Kind& kind : kKinds)
    pieces.insert(pieces.end(), kind.models.begin(), kind.models.end());
  return pieces;
}

SceneDescription FurnishHome(std::uint64_t seed, const PieceSizes& sizes) {
  Random random(seed, "home", 0);
  const HomePlan plan = PlanHome(random);
  SceneDescription scene;
  scene.seed = seed;
  scene.camera = scene.sensor.camera;
  scene.room_size_m = plan.size_m;
  scene.num_posters = 8;
  scene.ambient = 0.42;
  constexpr std::array<const char*, 3> kFloors = {"wood", "carpet", "tiles"};
  scene.floor = kFloors[random.Index(kFloors.size())];
  scene.openings = plan.openings;
  scene.partitions = plan.partitions;
  scene.clutter.num_per_table = 2;
  Light(plan, scene);
  Furnisher furnisher(plan, sizes, random, scene);
  furnisher.Furnish();
  AddWalk(plan, furnisher.taken(), scene);
  return scene;
}

}  // namespace deepslam::synth
