// The table of classes as a file.
#include <array>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "deepslam/class_table/class_table_yaml.h"

namespace deepslam::class_table {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string Entry(const std::string& name, const std::string& more = {}) {
  return fmt::format(
      "  - name: {}\n    labels: [{} label]\n    library: []\n    size_m: [0.3, 2]\n"
      "    height_m: [0.2, 2]\n    colour: [1, 2, 3]\n{}",
      name,
      name,
      more);
}

std::string File(int version, const std::vector<std::string>& entries) {
  std::string text = fmt::format("version: {}\nclasses:\n", version);
  for (const std::string& entry : entries) text += entry;
  return text;
}

std::string FaultsOf(const std::string& text) {
  const Result<ClassTable> table = DecodeClassTable(text, "c.yaml");
  EXPECT_FALSE(table.ok()) << text;
  if (table.ok()) return {};
  EXPECT_EQ(table.error().code, ErrorCode::kInvalidConfig);
  return table.error().message;
}

// Of a file without faults; of another one as many empty classes.
ClassTable TableOf(int version, const std::vector<std::string>& entries) {
  const Result<ClassTable> table = DecodeClassTable(File(version, entries), "c.yaml");
  EXPECT_TRUE(table.ok()) << table.error().message;
  return table.ok() ? *table : ClassTable{std::vector<ObjectClass>(entries.size())};
}

TEST(ClassTableFile, ReadsBackWhatItWrites) {
  for (const bool flag : {false, true}) {
    ClassTable table = DefaultClassTable();
    for (ObjectClass& c : table.classes) {
      c.traits.support_plane = c.traits.yaw_free = flag;
      c.traits.solid_inside = !flag;
    }
    const Result<ClassTable> read = DecodeClassTable(EncodeClassTable(table), "c.yaml");
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->classes.size(), table.classes.size());
    for (std::size_t n = 0; n < table.classes.size(); ++n)
      EXPECT_EQ(read->classes[n].traits, table.classes[n].traits) << table.classes[n].name;
    for (std::size_t n = 0; n < table.classes.size(); ++n) {
      EXPECT_EQ(read->classes[n].labels_elsewhere, table.classes[n].labels_elsewhere);
      EXPECT_EQ(read->classes[n].physics, table.classes[n].physics);
      EXPECT_EQ(read->classes[n].max_depth_m, table.classes[n].max_depth_m);
      EXPECT_EQ(read->classes[n].max_seat_height_m, table.classes[n].max_seat_height_m);
    }
    EXPECT_EQ(EncodeClassTable(*read), EncodeClassTable(table));
  }
}

TEST(ClassTableFile, TraitsThatAreLeftOutAreFalseWhateverTheName) {
  const ClassTable table = TableOf(
      2, {Entry("table"), Entry("altar", "    support_plane: true\n    yaw_free: false\n")});
  EXPECT_EQ(table.TraitsOf("table"), ClassTraits());
  EXPECT_EQ(table.TraitsOf("altar"), (ClassTraits{.support_plane = true}));
  EXPECT_EQ(table.Fallback(), nullptr);
}

TEST(ClassTableFile, ReadsHowDeepAndHowLevelThingsAre) {
  const ClassTable table = TableOf(5,
                                   {Entry("altar"),
                                    Entry("shelf", "    max_depth_m: 0.4\n"),
                                    Entry("chair", "    max_seat_height_m: 0.6\n")});
  EXPECT_GT(table.classes[0].max_depth_m, 1e9) << "any depth";
  EXPECT_EQ(table.classes[1].max_depth_m, 0.4);
  EXPECT_GT(table.classes[1].max_seat_height_m, 1e9) << "any height";
  EXPECT_EQ(table.classes[2].max_seat_height_m, 0.6);
  for (const auto& [field, since] : {std::pair("max_depth_m", 4), {"max_seat_height_m", 5}}) {
    const auto entry = [field = field](const char* value) {
      return Entry("shelf", fmt::format("    {}: {}\n", field, value));
    };
    for (const char* none : {"0", "-1", "deep", "[0.1, 0.4]", "400", ".nan"}) {
      EXPECT_THAT(FaultsOf(File(since, {entry(none)})),
                  HasSubstr(fmt::format("class shelf, {}: must lie in (0, 20]", field)))
          << none;
    }
    EXPECT_THAT(FaultsOf(File(since - 1, {entry("0.4")})),
                HasSubstr(fmt::format(
                    "is not of version {}; write `version: {}` above", since - 1, since)));
  }
}

TEST(ClassTableFile, ReadsWhatThingsRestOn) {
  const ClassTable table = TableOf(2,
                                   {Entry("chair"),
                                    Entry("tv", "    stands_on: [furniture, wall]\n"),
                                    Entry("plant", "    stands_on: [furniture, floor]\n")});
  EXPECT_EQ(table.TraitsOf("chair").supports, Supports());
  EXPECT_EQ(table.TraitsOf("tv").supports,
            (Supports{.floor = false, .furniture = true, .wall = true}));
  EXPECT_EQ(table.TraitsOf("plant").supports, (Supports{.furniture = true}));
  for (const char* none : {"[]", "floor", "{floor: true}", "7"}) {
    EXPECT_THAT(FaultsOf(File(2, {Entry("tv", fmt::format("    stands_on: {}\n", none))})),
                HasSubstr("class tv, stands_on: must be a list of floor, furniture, wall"))
        << none;
  }
  EXPECT_THAT(FaultsOf(File(2, {Entry("tv", "    stands_on: [floor, ceiling]\n")})),
              HasSubstr("c.yaml:9: class tv, stands_on: \"ceiling\" is none of floor, furniture"));
  EXPECT_THAT(FaultsOf(File(1, {Entry("tv", "    stands_on: [wall]\n")})),
              HasSubstr("stands_on: is not of version 1"));
}

// What of COCO's names furnishes a home, and is large enough to be mapped.
constexpr std::array kHouseholdNames = {"chair",
                                        "couch",
                                        "bed",
                                        "dining table",
                                        "potted plant",
                                        "toilet",
                                        "tv",
                                        "laptop",
                                        "oven",
                                        "sink",
                                        "microwave",
                                        "refrigerator",
                                        "bench",
                                        "suitcase",
                                        "bicycle",
                                        "clock",
                                        "vase",
                                        "toaster"};

TEST(DefaultClasses, EveryHouseholdNameOfCocoIsAClass) {
  const ClassTable table = DefaultClassTable();
  for (const char* name : kHouseholdNames) EXPECT_NE(table.FindByLabel(name), nullptr) << name;
  for (const char* name : {"person", "dog", "car", "pizza", "fork"})
    EXPECT_EQ(table.FindByLabel(name), nullptr) << name;
}

TEST(DefaultClasses, SizesAreThoseOfRealThings) {
  std::set<std::array<int, 3>> colours;
  for (const ObjectClass& c : DefaultClassTable().classes) {
    EXPECT_LT(c.min_size_m, c.max_size_m) << c.name;
    EXPECT_LT(c.min_height_m, c.max_height_m) << c.name;
    EXPECT_LE(c.max_height_m, c.max_size_m + 0.2) << c.name << ": its height is one of its sides";
    EXPECT_GE(c.max_size_m, 0.4) << c.name << " would never be large enough for the map";
    EXPECT_LE(c.max_height_m, 2.8) << c.name << " fits under no ceiling";
    EXPECT_TRUE(colours.insert(c.colour_rgb).second) << c.name << " looks like another";
  }
}

TEST(DefaultClasses, TraitsFitOneAnother) {
  const ClassTable table = DefaultClassTable();
  ASSERT_NE(table.Fallback(), nullptr);
  for (const ObjectClass& c : table.classes) {
    if (c.traits.fused_only) {
      EXPECT_TRUE(c.library_classes.empty()) << c.name << ": models that nobody may use";
      EXPECT_FALSE(c.detector_labels.empty()) << c.name << ": nothing would find it";
    }
    if (c.traits.support_plane) {
      EXPECT_TRUE(c.traits.supports.floor) << c.name;
    }
  }
}

TEST(ClassTableFile, ReadsWhatOtherProgramsCallAClassAndWhatItWeighs) {
  const ClassTable table =
      TableOf(3,
              {Entry("chair"),
               Entry("sink",
                     "    coco: [81, sink]\n    nyu40: [34, \"a, b\"]\n    density_kg_m3: 250.5\n"
                     "    fixed: true\n")});
  EXPECT_EQ(table.classes[0].labels_elsewhere, CommonLabels());
  EXPECT_EQ(table.classes[0].physics, ClassPhysics());
  EXPECT_EQ(table.classes[1].labels_elsewhere.coco, (ClassLabel{81, "sink"}));
  EXPECT_EQ(table.classes[1].labels_elsewhere.nyu40, (ClassLabel{34, "a, b"}));
  EXPECT_EQ(table.classes[1].physics, (ClassPhysics{250.5, true}));
  const auto fault_of = [](const std::string& line) {
    return FaultsOf(File(3, {Entry("sink", "    " + line + "\n")}));
  };
  for (const char* value : {"81", "[81]", "[sink, 81]", "[-1, sink]", "[81, \"\"]", "{81: sink}"}) {
    EXPECT_THAT(fault_of(fmt::format("scannet200: {}", value)),
                HasSubstr("c.yaml:9: class sink, scannet200: must be [id, name]"))
        << value;
  }
  for (const char* value : {"0", "-1", "nan", "heavy", "1e9", "[1]"}) {
    EXPECT_THAT(fault_of(fmt::format("density_kg_m3: {}", value)),
                HasSubstr("class sink, density_kg_m3: must lie in (0, 25000]"))
        << value;
  }
  EXPECT_THAT(fault_of("fixed: 1"),
              HasSubstr("class sink, fixed: is \"1\", must be true or false"));
  EXPECT_THAT(FaultsOf(File(2, {Entry("sink", "    fixed: true\n")})),
              HasSubstr("fixed: is not of version 2; write `version: 3` above"));
}

TEST(DefaultClasses, TheirIdsTellThemApartInEverySet) {
  std::set<int> coco;
  std::set<int> scannet200;
  for (const ObjectClass& c : DefaultClassTable().classes) {
    const CommonLabels& labels = c.labels_elsewhere;
    EXPECT_TRUE(labels.coco || labels.nyu40 || labels.scannet200) << c.name;
    if (labels.coco) {
      EXPECT_TRUE(coco.insert(labels.coco->id).second) << c.name;
    }
    if (labels.coco && c.traits.fused_only) {  // detectors of COCO's names find it
      EXPECT_THAT(c.detector_labels, testing::Contains(labels.coco->name)) << c.name;
    }
    if (labels.scannet200) {
      EXPECT_TRUE(scannet200.insert(labels.scannet200->id).second) << c.name;
    }
    if (labels.nyu40) {
      EXPECT_LE(labels.nyu40->id, 40) << c.name;
    }
  }
}

// Tables that users have: what programs of that version took from the name still holds.
TEST(ClassTableFile, ReadsVersionOneWithTheTraitsItsNamesMeant) {
  const ClassTable table =
      TableOf(1, {Entry("table"), Entry("desk"), Entry("bed"), Entry("plant"), Entry("furniture")});
  const auto traits = [&](const char* name) { return table.TraitsOf(name); };
  EXPECT_EQ(traits("table"), (ClassTraits{.support_plane = true, .yaw_free = true}));
  EXPECT_EQ(traits("desk"), (ClassTraits{.support_plane = true}));
  EXPECT_EQ(traits("bed"), (ClassTraits{.solid_inside = true}));
  EXPECT_EQ(traits("plant"), ClassTraits());
  ASSERT_NE(table.Fallback(), nullptr);
  EXPECT_EQ(table.Fallback()->name, "furniture");
  EXPECT_TRUE(traits("furniture").solid_inside && traits("furniture").yaw_free);
  EXPECT_THAT(
      FaultsOf(File(1, {Entry("table", "    yaw_free: true\n")})),
      HasSubstr("c.yaml:9: class table, yaw_free: is not of version 1; write `version: 2`"));
}

TEST(ClassTableFile, RefusesOtherVersions) {
  EXPECT_THAT(FaultsOf(File(6, {Entry("table")})),
              AllOf(HasSubstr("c.yaml:1: version is 6, written for a later deepslam"),
                    HasSubstr("reads 1 to 5")));
  for (const std::string version : {"0", "-1", "two", "[2]", "1.5", "99999999999"}) {
    EXPECT_THAT(FaultsOf("version: " + version + "\nclasses:\n" + Entry("table")),
                HasSubstr("version must be 1 to 5"))
        << version;
  }
  EXPECT_THAT(FaultsOf("classes:\n" + Entry("table")), HasSubstr("version must be 1 to 5"));
}

TEST(ClassTableFile, TellsAllFaultsWithLineClassAndField) {
  const std::string faults =
      FaultsOf(File(2,
                    {Entry("table", "    support_plane: yes\n    suport_plane: true\n"),
                     Entry("Chair", "    yaw_free: [true]\n"),
                     Entry("plant", "    fallback: true\n"),
                     Entry("furniture", "    fallback: true\n"),
                     Entry("plant"),
                     "  - name: rug\n    labels: rug\n    size_m: [2, 1]\n    height_m: [0, 1]\n"
                     "    colour: [1, 2, 300]\n",
                     "  - name: lamp\n    labels: [table label]\n    colour: red\n",
                     "  - 7\n"}));
  EXPECT_THAT(faults,
              HasSubstr("c.yaml:9: class table, support_plane: is \"yes\", must be true or false"));
  EXPECT_THAT(
      faults,
      HasSubstr(
          "c.yaml:10: class table: unknown key \"suport_plane\"; known are name, "
          "labels, library, size_m, height_m, max_depth_m, max_seat_height_m, colour, stands_on, "
          "support_plane"));
  EXPECT_THAT(faults, HasSubstr("class 2: name \"Chair\" must be lower-case"));
  EXPECT_THAT(faults, HasSubstr("class 2, yaw_free: is \"\", must be true or false"));
  EXPECT_THAT(faults, HasSubstr("class furniture: is a fallback, as class plant is already"));
  EXPECT_THAT(faults, HasSubstr("class plant: stands twice"));
  EXPECT_THAT(faults, HasSubstr("class plant: label \"plant label\" belongs to another class"));
  EXPECT_THAT(faults, HasSubstr("class rug, labels: must be a list"));
  EXPECT_THAT(faults, HasSubstr("class rug, size_m: must be [least, greatest] in metres"));
  EXPECT_THAT(faults, HasSubstr("class rug, height_m: must be [least, greatest] in metres"));
  EXPECT_THAT(faults, HasSubstr("class rug, colour: red, green and blue must lie in [0, 255]"));
  EXPECT_THAT(faults, HasSubstr("class lamp: label \"table label\" belongs to another class"));
  EXPECT_THAT(faults, HasSubstr("class lamp, colour: must be [red, green, blue]"));
  EXPECT_THAT(faults, HasSubstr("class 8: must be a map"));
}

TEST(ClassTableFile, BearsWhatIsNoTable) {
  for (const char* text : {"",
                           "7",
                           "[1, 2]",
                           "version: 2",
                           "version: 2\nclasses: 3",
                           "version: 2\nclasses: []",
                           "version: 2\nclasses:\n  - {",
                           "a: &a [*a]"})
    EXPECT_THAT(FaultsOf(text), HasSubstr("c.yaml")) << text;
  EXPECT_THAT(FaultsOf("version: 2\nclasses:\n" + Entry("table") + "things: 3\n"),
              HasSubstr("unknown key \"things\"; known are version, classes"));
  EXPECT_THAT(FaultsOf(std::string((1U << 20) + 1, '#')), HasSubstr("bytes are too many"));
  const std::string long_value(1000, 'x');
  EXPECT_THAT(FaultsOf(File(2, {Entry("table", "    yaw_free: " + long_value + "\n")})),
              Not(HasSubstr(long_value)));
}

}  // namespace
}  // namespace deepslam::class_table
