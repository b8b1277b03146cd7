#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "deepslam/library/canonical.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/library/classify.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "support/box_meshes.h"
#include "support/temp_dir.h"

namespace deepslam::library {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing_support::ChairMesh;
using testing_support::ReadText;
using testing_support::TableMesh;
using testing_support::TempDir;
using testing_support::WriteText;

// OBJ text of a mesh given z up and x front: y up and z front in the file.
std::string ObjText(const TriangleMesh& mesh) {
  std::ostringstream text;
  text << "mtllib missing.mtl\nusemtl nothing\n";
  for (const Eigen::Vector3f& v : mesh.vertices) {
    text << "v " << v.y() << ' ' << v.z() << ' ' << v.x() << '\n';
  }
  for (const auto& face : mesh.faces) {
    text << "f " << face[0] + 1 << ' ' << face[1] + 1 << ' ' << face[2] + 1 << '\n';
  }
  return text.str();
}

// Lines of one item; `size` is its three lengths "width depth height", in centimetres.
std::string Item(int n,
                 const std::string& id,
                 const std::string& name,
                 const std::string& model,
                 const std::string& size) {
  std::istringstream lengths(size);
  std::string width;
  std::string depth;
  std::string height;
  lengths >> width >> depth >> height;
  std::ostringstream text;
  text << "id#" << n << '=' << id << "\nname#" << n << '=' << name << "\nmodel#" << n << "=/"
       << model << "\ncreator#" << n << "=Ren\xE9\nwidth#" << n << '=' << width << "\ndepth#" << n
       << '=' << depth << "\nheight#" << n << '=' << height << '\n';
  return text.str();
}

void WriteZip(const fs::path& file, const std::map<std::string, std::string>& entries) {
  int error = 0;
  zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  ASSERT_NE(archive, nullptr);
  for (const auto& [name, bytes] : entries) {
    zip_source_t* const source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    ASSERT_GE(zip_file_add(archive, name.c_str(), source, ZIP_FL_OVERWRITE), 0);
  }
  ASSERT_EQ(zip_close(archive), 0);
}

TEST(Catalogue, ReadsLatin1EscapesAndSizes) {
  const Result<Catalogue> catalogue = ParseCatalogue(
      "# comment\nname=Test\nlicense=Free \\u00a9 You\n"
      "id#2=T#b\nname#2=\\u6905\\u5b50\nmodel#2=/m/b.obj\nwidth#2=50\ndepth#2=60.5\nheight#2=90\n"
      "modelRotation#2=0 0 1 0 1 0 -1 0 0\n"
      "id#1=T#a\nname#1=Caf\xE9 chair\nmodel#1=/m/a.obj\nwidth#1=40\ndepth#1=41\nheight#1=80\n");
  ASSERT_TRUE(catalogue.ok());
  EXPECT_EQ(catalogue->licence, "Free \xC2\xA9 You");
  ASSERT_EQ(catalogue->items.size(), 2U);
  EXPECT_EQ(catalogue->items[0].name, "Caf\xC3\xA9 chair");
  EXPECT_EQ(catalogue->items[0].fault, "");
  const CatalogueItem& second = catalogue->items[1];
  EXPECT_EQ(second.name, "\xE6\xA4\x85\xE5\xAD\x90");
  EXPECT_EQ(second.model, "m/b.obj");
  EXPECT_DOUBLE_EQ(second.depth_m, 0.605);
  EXPECT_EQ(second.rotation * Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());
}

TEST(Catalogue, BadItemsSayWhatIsWrong) {
  const std::string good = "id#1=T#a\nname#1=Chair\nmodel#1=/a.obj\n";
  const auto fault = [&](const std::string& rest) {
    return ParseCatalogue(good + rest)->items[0].fault;
  };
  EXPECT_EQ(fault("width#1=40\ndepth#1=41\nheight#1=80\n"), "");
  EXPECT_THAT(fault("width#1=40\ndepth#1=41\n"), HasSubstr("height"));
  EXPECT_THAT(fault("width#1=wide\ndepth#1=41\nheight#1=80\n"), HasSubstr("width"));
  EXPECT_THAT(fault("width#1=40\ndepth#1=-3\nheight#1=80\n"), HasSubstr("depth"));
  EXPECT_THAT(fault("width#1=nan\ndepth#1=41\nheight#1=80\n"), HasSubstr("width"));
  EXPECT_THAT(fault("width#1=40\ndepth#1=41\nheight#1=1e9\n"), HasSubstr("height"));
  EXPECT_THAT(fault("width#1=40\ndepth#1=41\nheight#1=80\nmodelRotation#1=1 0 0 0 1\n"),
              HasSubstr("modelRotation"));
  EXPECT_THAT(fault("width#1=40\ndepth#1=41\nheight#1=80\nmodelRotation#1=9 0 0 0 9 0 0 0 9\n"),
              HasSubstr("modelRotation"));
  EXPECT_FALSE(ParseCatalogue("").ok());
  EXPECT_FALSE(ParseCatalogue(std::string("\x00\xFF=\\u12\n=\n#", 9)).ok());
  EXPECT_EQ(ParseCatalogue("id#1=a\\")->items.size(), 1U);
}

std::string ClassOf(const std::string& name, double width_m, double depth_m, double height_m) {
  CatalogueItem item;
  item.name = name;
  item.width_m = width_m;
  item.depth_m = depth_m;
  item.height_m = height_m;
  return ClassOfItem(item).value_or("-");
}

TEST(Classify, TakesFurnitureAndLeavesNamesakes) {
  EXPECT_EQ(ClassOf("Dining Chair", 0.45, 0.5, 0.9), "chair");
  EXPECT_EQ(ClassOf("Armchair", 0.8, 0.8, 0.9), "chair");
  EXPECT_EQ(ClassOf("Desk", 1.4, 0.7, 0.72), "table");
  EXPECT_EQ(ClassOf("Bedside table", 0.5, 0.4, 0.5), "cabinet");
  EXPECT_EQ(ClassOf("TV stand", 1.4, 0.5, 0.5), "cabinet");
  EXPECT_EQ(ClassOf("Bookcase", 0.9, 0.3, 1.8), "shelf");
  EXPECT_EQ(ClassOf("Sofa", 2.0, 0.9, 0.8), "sofa");
  EXPECT_EQ(ClassOf("Child bed", 0.9, 2.0, 0.8), "bed");
  EXPECT_EQ(ClassOf("Table fan", 0.3, 0.3, 0.4), "-");
  EXPECT_EQ(ClassOf("Desk lamp", 0.6, 0.6, 0.6), "-");
  EXPECT_EQ(ClassOf("Tablet", 0.5, 0.5, 0.5), "-");
  EXPECT_EQ(ClassOf("Wheelchair", 0.6, 0.8, 0.9), "-");
  EXPECT_EQ(ClassOf("Changing table", 1.2, 0.5, 1.0), "-");
  EXPECT_EQ(ClassOf("Chair", 0.1, 0.1, 0.2), "-") << "a toy";
  CatalogueItem wall;
  wall.name = "Cabinet";
  wall.width_m = wall.depth_m = wall.height_m = 0.7;
  wall.elevation_m = 1.45;
  EXPECT_FALSE(ClassOfItem(wall).has_value());
}

TEST(Canonical, TurnsAChairToItsFrontWhateverTheFileSays) {
  const TriangleMesh chair = ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.04F);
  CatalogueItem item;
  item.width_m = 0.45;
  item.depth_m = 0.5;
  item.height_m = 0.9;
  const Result<TriangleMesh> mesh = ReadObj(ObjText(chair));
  ASSERT_TRUE(mesh.ok());
  const Result<CanonicalModel> right = MakeCanonical(*mesh, item, "chair");
  ASSERT_TRUE(right.ok());
  EXPECT_GT(shape::GridIntersectionOverUnion(right->shape, *shape::Voxelize(chair)), 0.9);
  EXPECT_TRUE(right->size_m.isApprox(Eigen::Vector3d(0.5, 0.45, 0.9)));
  // The same file with a rotation that puts the back in front.
  item.rotation = Eigen::DiagonalMatrix<double, 3>(-1, 1, -1);
  const Result<CanonicalModel> turned = MakeCanonical(*mesh, item, "chair");
  ASSERT_TRUE(turned.ok());
  EXPECT_GT(shape::GridIntersectionOverUnion(right->shape, turned->shape), 0.9);
}

TEST(Canonical, RefusesBrokenMeshes) {
  EXPECT_FALSE(ReadObj("").ok());
  EXPECT_FALSE(ReadObj("f 1 2 3\n").ok());
  EXPECT_FALSE(ReadObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 7 8 9\n").ok());
  CatalogueItem item;
  item.width_m = item.depth_m = item.height_m = 1;
  const Result<TriangleMesh> flat = ReadObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_TRUE(flat.ok());
  EXPECT_FALSE(MakeCanonical(*flat, item, "chair").ok());
}

class Library : public testing::Test {
 protected:
  void SetUp() override {
    const std::string chair = ObjText(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.05F));
    const std::string stool = ObjText(ChairMesh(0.4F, 0.4F, 0.6F, 0.65F, 0.05F));
    const std::string table = ObjText(TableMesh(1.4F, 0.8F, 0.74F, 0.07F));
    const std::string properties =
        "name=Test\nlicense=Public domain\n" +
        Item(1, "Test#chair", "Chair", "a/chair.obj", "45 50 90") +
        Item(2, "Test#larger", "Large chair", "a/chair.obj", "50 56 100") +
        Item(3, "Test#table", "Table", "a/table.obj", "140 80 74") +
        Item(4, "Test#tablet", "Table", "a/table.obj", "140 80 74") +
        Item(5, "Test#gone", "Chair", "a/gone.obj", "45 50 90") +
        Item(6, "Test#broken", "Chair", "a/broken.obj", "45 50 90") +
        Item(7, "Test#lamp", "Table lamp", "a/table.obj", "45 50 60") +
        Item(8, "Test#stool", "Stool", "a/stool.obj", "40 40 65") +
        Item(9, "Test#sizeless", "Chair", "a/chair.obj", "x 50 90");
    WriteZip(dir_.path() / "Test.sh3f",
             {{"PluginFurnitureCatalog.properties", properties},
              {"LICENSE.TXT", "do as you please"},
              {"a/chair.obj", chair},
              {"a/stool.obj", stool},
              {"a/table.obj", table},
              {"a/broken.obj", "v 1 2\nf x y z\n"}});
    options_.catalogues = dir_.path();
    options_.out = dir_.path() / "library";
  }

  Result<LibrarySummary> Build() {
    SilentProgress progress;
    return BuildLibrary(options_, progress);
  }

  // The message of the refusal, after `change` of the text of a file; the file is put back.
  std::string Refusal(const std::string& file,
                      const std::function<std::string(std::string)>& change) {
    const fs::path path = options_.out / file;
    const std::string before = ReadText(path);
    WriteText(path, change(before));
    const Result<ModelLibrary> library = LoadLibrary(options_.out);
    WriteText(path, before);
    return library.ok() ? "accepted" : library.error().message;
  }

  TempDir dir_;
  BuildLibraryOptions options_;
};

TEST_F(Library, HoldsEachProductOnceAndSaysWhatItLeftOut) {
  const Result<LibrarySummary> summary = Build();
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_EQ(summary->num_catalogue_items, 9);
  EXPECT_THAT(summary->per_class,
              testing::ElementsAre(testing::Pair("chair", 3), testing::Pair("table", 1)));
  EXPECT_THAT(summary->dropped,
              testing::UnorderedElementsAre(HasSubstr("Test#tablet: same shape"),
                                            HasSubstr("Test#gone: "),
                                            HasSubstr("Test#broken: "),
                                            HasSubstr("Test#sizeless: width")));
  const Result<ModelLibrary> library = LoadLibrary(options_.out);
  ASSERT_TRUE(library.ok()) << library.error().message;
  ASSERT_EQ(library->models.size(), 4U);
  EXPECT_EQ(library->checksum, summary->checksum);
  const LibraryModel& chair = library->models[0];
  EXPECT_EQ(chair.id, "test/chair");
  EXPECT_EQ(chair.creator, "Ren\xC3\xA9");
  EXPECT_TRUE(chair.size_m.isApprox(Eigen::Vector3d(0.5, 0.45, 0.9)));
  EXPECT_GT(shape::GridIntersectionOverUnion(
                chair.shape, *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.05F))),
            0.9);
  const std::string licences = ReadText(options_.out / "LICENSES.txt");
  EXPECT_THAT(licences, HasSubstr("test/chair: Chair by Ren\xC3\xA9, Public domain"));
  EXPECT_THAT(licences, HasSubstr("do as you please"));
}

TEST_F(Library, IsTheSameWhenBuiltAgain) {
  const std::string first = Build()->checksum;
  const std::string index = ReadText(options_.out / "library.json");
  EXPECT_EQ(Build()->checksum, first);
  EXPECT_EQ(ReadText(options_.out / "library.json"), index);
}

TEST_F(Library, WithheldProductsStayOutById_AndByShapeInAnySize) {
  options_.withheld = {"Test#chair"};
  const Result<LibrarySummary> summary = Build();
  ASSERT_TRUE(summary.ok());
  EXPECT_THAT(summary->dropped,
              testing::Contains(HasSubstr("Test#larger: shape like the withheld Test#chair")));
  const Result<ModelLibrary> library = LoadLibrary(options_.out);
  const VoxelGrid chair = *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.05F));
  for (const LibraryModel& model : library->models)
    EXPECT_FALSE(ShapesAlike(model.shape, chair)) << model.id;
  options_.withheld = {"Test#unknown"};
  EXPECT_FALSE(Build().ok());
}

// What training renders: the withheld products marked, and what is of their shape on neither side.
TEST_F(Library, DesignsForTrainingMarkWhatIsWithheldAndLeaveOutWhatIsLikeIt) {
  SilentProgress progress;
  const auto designs = ReadDesigns(options_.catalogues, {"Test#chair"}, {"chair"}, progress);
  ASSERT_TRUE(designs.ok()) << designs.error().message;
  std::map<std::string, bool> withheld;
  for (const CatalogueDesign& design : *designs) {
    withheld[design.item.id] = design.withheld;
    EXPECT_EQ(design.catalogue, "Test.sh3f");
  }
  EXPECT_THAT(
      withheld,
      testing::ElementsAre(testing::Pair("Test#chair", true), testing::Pair("Test#stool", false)))
      << "the larger chair is of the withheld one's shape; tables were not asked for";
  EXPECT_FALSE(ReadDesigns(options_.catalogues, {"Test#unknown"}, {"chair"}, progress).ok());
  EXPECT_FALSE(ReadDesigns(options_.catalogues, {"Test#gone"}, {"chair"}, progress).ok());
  EXPECT_FALSE(ReadDesigns(dir_.path() / "nowhere", {}, {"chair"}, progress).ok());
}

TEST_F(Library, DesignsForTrainingAreTurnedToTheirFronts) {
  SilentProgress progress;
  const auto designs = ReadDesigns(options_.catalogues, {}, {"chair"}, progress);
  ASSERT_TRUE(designs.ok()) << designs.error().message;
  const VoxelGrid chair = *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.05F));
  for (const CatalogueDesign& design : *designs) {
    if (design.item.id != "Test#chair") continue;
    EXPECT_GT(shape::GridIntersectionOverUnion(design.model.shape, chair), 0.9);
    return;
  }
  FAIL() << "Test#chair is missing";
}

TEST_F(Library, RefusesFoldersThatAreNotItsOwn) {
  options_.out = dir_.path() / "home";
  WriteText(options_.out / "thesis.txt", "years of work");
  EXPECT_FALSE(Build().ok());
  EXPECT_EQ(ReadText(options_.out / "thesis.txt"), "years of work");
  options_.out = dir_.path() / "library";
  options_.catalogues = dir_.path() / "home";
  EXPECT_THAT(Build().error().message, HasSubstr("sweethome3d-furniture"));
  WriteText(options_.catalogues / "bad.sh3f", "no zip");
  EXPECT_THAT(Build().error().message, HasSubstr("bad.sh3f"));
}

TEST_F(Library, RefusesDamage) {
  ASSERT_TRUE(Build().ok());
  const auto replaced = [](const std::string& from, const std::string& to) {
    return [=](std::string text) {
      const std::size_t at = text.find(from);
      EXPECT_NE(at, std::string::npos) << from;
      return text.replace(at, from.size(), to);
    };
  };
  const std::string model = "models/test__chair.binvox";
  EXPECT_THAT(Refusal(model, [](std::string t) { return t.substr(0, t.size() / 2); }),
              HasSubstr(model));
  EXPECT_THAT(Refusal(model,
                      [](std::string t) {
                        t.back() ^= 1;
                        return t;
                      }),
              HasSubstr("checksum"));
  const std::string index = "library.json";
  EXPECT_THAT(Refusal(index, replaced("\"version\": 1", "\"version\": 2")), HasSubstr("version 2"));
  EXPECT_THAT(Refusal(index, replaced("deepslam-furniture", "something-else")),
              HasSubstr("no index"));
  EXPECT_THAT(Refusal(index, replaced("0.45", "0.55")), HasSubstr("damaged"));
  EXPECT_THAT(Refusal(index, replaced("Ren", "Jan")), HasSubstr("damaged"));
  for (const char* text : {"",
                           "{",
                           "[]",
                           "null",
                           "{\"format\": 3}",
                           "{\"format\":\"deepslam-furniture\",\"version\":1}"}) {
    EXPECT_NE(Refusal(index, [&](const std::string&) { return std::string(text); }), "accepted")
        << text;
  }
  EXPECT_TRUE(LoadLibrary(options_.out).ok());
  fs::remove(options_.out / model);
  EXPECT_THAT(LoadLibrary(options_.out).error().message, HasSubstr("library build"));
  EXPECT_THAT(LoadLibrary(dir_.path() / "nowhere").error().message, HasSubstr("library build"));
}

TEST_F(Library, SplitKeepsShapesTogetherAndTakesItsShareOfEveryClass) {
  SilentProgress progress;
  const auto ids_at = [&](double share) {
    const auto withheld = ChooseWithheld(options_.catalogues, share, progress);
    EXPECT_TRUE(withheld.ok());
    std::set<std::string> ids;
    for (const WithheldProduct& product : *withheld) ids.insert(product.id);
    return ids;
  };
  // Chairs that can be read: two of one shape, and a stool; tables: two of one shape.
  EXPECT_THAT(ids_at(0.0), testing::IsEmpty());
  EXPECT_THAT(ids_at(0.34), testing::ElementsAre("Test#stool")) << "one of three chairs";
  const std::set<std::string> two_thirds = ids_at(0.67);
  EXPECT_EQ(two_thirds.contains("Test#chair"), two_thirds.contains("Test#larger"));
  EXPECT_EQ(two_thirds.size(), 1U) << "of two like tables only both could be withheld";
  EXPECT_THAT(
      ids_at(1.0),
      testing::ElementsAre("Test#chair", "Test#larger", "Test#stool", "Test#table", "Test#tablet"));
}

TEST_F(Library, SplitIsReadAsAListAndLeavesNothingAlikeInTheLibrary) {
  SilentProgress progress;
  const auto withheld = ChooseWithheld(options_.catalogues, 0.34, progress);
  ASSERT_TRUE(withheld.ok());
  WriteText(dir_.path() / "list.yaml", WithheldYaml(*withheld));
  const Result<std::vector<std::string>> ids = ReadWithheldModels(dir_.path() / "list.yaml");
  ASSERT_TRUE(ids.ok()) << ids.error().message;
  EXPECT_THAT(*ids, testing::ElementsAre("Test#stool"));
  options_.withheld = *ids;
  const Result<LibrarySummary> summary = Build();
  ASSERT_TRUE(summary.ok());
  EXPECT_THAT(summary->dropped, testing::Not(testing::Contains(HasSubstr("shape like"))));
}

TEST(ShapesAlike, SeesThroughSizeStretchAndTurn) {
  const VoxelGrid table = *shape::Voxelize(TableMesh(1.4F, 0.8F, 0.74F, 0.12F));
  const VoxelGrid chair = *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.08F));
  EXPECT_TRUE(ShapesAlike(table, table));
  EXPECT_TRUE(ShapesAlike(chair, shape::TurnGrid(chair, 1)));
  // A little deeper: every board falls on other voxels.
  EXPECT_TRUE(ShapesAlike(chair, *shape::Voxelize(ChairMesh(0.45F, 0.51F, 0.45F, 0.9F, 0.08F))));
  EXPECT_TRUE(ShapesAlike(chair, shape::StretchGrid(chair, {1.3, 0.9, 1.0})));
  EXPECT_FALSE(ShapesAlike(chair, *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.6F, 0.9F, 0.08F))));
  EXPECT_FALSE(ShapesAlike(chair, table));
  EXPECT_FALSE(ShapesAlike(chair, VoxelGrid()));
}

TEST(ShapesAlike, SeesThroughEveryTurnOfEveryStretchedShape) {
  const VoxelGrid table = *shape::Voxelize(TableMesh(1.4F, 0.8F, 0.74F, 0.12F));
  const VoxelGrid chair = *shape::Voxelize(ChairMesh(0.45F, 0.5F, 0.45F, 0.9F, 0.08F));
  for (const VoxelGrid* const shape : {&table, &chair}) {
    for (const Eigen::Vector3d& factors :
         {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1.6, 0.7, 1), Eigen::Vector3d(0.6, 1.2, 1.5)}) {
      for (int turns = 0; turns < 4; ++turns) {
        const VoxelGrid other = shape::TurnGrid(shape::StretchGrid(*shape, factors), turns);
        EXPECT_TRUE(ShapesAlike(*shape, other)) << factors.transpose() << " turned " << turns;
        EXPECT_TRUE(ShapesAlike(other, *shape)) << factors.transpose() << " turned " << turns;
      }
    }
  }
}

TEST(WithheldModels, AreReadFromTheList) {
  TempDir dir;
  const fs::path file = dir.path() / "withheld.yaml";
  WriteText(file,
            "# why\nwithheld:\n  - id: \"A B#c\"\n    mesh: x/y.obj\n  - id: \"D#e\"  # note\n");
  EXPECT_THAT(*ReadWithheldModels(file), testing::ElementsAre("A B#c", "D#e"));
  WriteText(file, "withheld:\n  - id: A#c\n");
  EXPECT_THAT(ReadWithheldModels(file).error().message, HasSubstr(":2"));
  EXPECT_FALSE(ReadWithheldModels(dir.path() / "none.yaml").ok());
}

}  // namespace
}  // namespace deepslam::library
