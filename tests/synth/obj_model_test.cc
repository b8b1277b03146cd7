#include "deepslam/synth/obj_model.h"

#include <limits>

#include <gmock/gmock.h>

#include "deepslam/geometry/box.h"
#include "deepslam/image_codec/jpeg.h"
#include "deepslam/image_codec/png.h"

namespace deepslam::synth {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const char* const kWedge =
    "mtllib wedge.mtl\nv 0 0 0\nv 2 0 0\nv 0 4 0\nv 0 0 1\nusemtl red\nf 1 2 3\nf 1 2 4\nusemtl "
    "none\nf 1 3 4\nf 2 3 4\n";

std::optional<std::string> Materials(const std::string& name) {
  if (name != "wedge.mtl") return std::nullopt;
  return "newmtl red\nKd 1 0 0\n";
}

std::optional<std::string> Nothing(const std::string&) { return std::nullopt; }

TEST(ParseObjModel, BringsTheBoxToRealSizeInTheObjectFrame) {
  const Result<FurnitureModel> model =
      ParseObjModel(kWedge, Materials, Eigen::Matrix3d::Identity(), CatalogueSize{0.4, 0.5, 0.9});
  ASSERT_TRUE(model.ok()) << model.error().message;
  Box3 box;
  for (const Eigen::Vector3f& v : model->mesh.vertices) box.Extend(v.cast<double>());
  // x is the front (the file's z, depth), y the file's x (width), z up (the file's y).
  EXPECT_LT((box.max - Eigen::Vector3d(0.25, 0.2, 0.45)).norm(), 1e-6);
  EXPECT_LT((box.min + Eigen::Vector3d(0.25, 0.2, 0.45)).norm(), 1e-6);
  EXPECT_EQ(model->size_m, Eigen::Vector3d(0.5, 0.4, 0.9));
}

TEST(ParseObjModel, TurnsBeforeItScales) {
  // Exchanging z and y as some catalogue entries do: the file's z becomes the height.
  const Eigen::Matrix3d rotation = (Eigen::Matrix3d() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished();
  const Result<FurnitureModel> model =
      ParseObjModel(kWedge, Materials, rotation, CatalogueSize{0.4, 0.5, 0.9});
  ASSERT_TRUE(model.ok());
  // Vertex 4 is the only one with z = 1 in the file: it alone is on top now.
  int num_top = 0;
  for (const Eigen::Vector3f& v : model->mesh.vertices) num_top += v.z() > 0.449f ? 1 : 0;
  EXPECT_EQ(num_top, 3) << "the three faces around vertex 4";
}

TEST(ParseObjModel, PaintsFacesByMaterialAndUnknownOnesGrey) {
  const Result<FurnitureModel> model =
      ParseObjModel(kWedge, Materials, Eigen::Matrix3d::Identity(), CatalogueSize{1, 1, 1});
  ASSERT_EQ(model->mesh.faces.size(), 4u);
  ASSERT_EQ(model->mesh.colours.size(), 12u);
  EXPECT_EQ(model->mesh.colours[model->mesh.faces[0][0]], (Rgb8{255, 0, 0}));
  EXPECT_EQ(model->mesh.colours[model->mesh.faces[2][0]], (Rgb8{153, 153, 153}));
  const Result<FurnitureModel> grey =
      ParseObjModel(kWedge, Nothing, Eigen::Matrix3d::Identity(), CatalogueSize{1, 1, 1});
  ASSERT_TRUE(grey.ok()) << "a missing material library is no reason to refuse";
  EXPECT_EQ(grey->mesh.colours[0], (Rgb8{153, 153, 153}));
}

TEST(ParseObjModel, BrokenTexturesAreLeftOut) {
  const auto beside = [](const std::string& name) -> std::optional<std::string> {
    if (name == "wedge.mtl") return "newmtl red\nKd 1 0 0\nmap_Kd wood.jpg\n";
    return "this is no picture";
  };
  const Result<FurnitureModel> model =
      ParseObjModel(kWedge, beside, Eigen::Matrix3d::Identity(), CatalogueSize{1, 1, 1});
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->mesh.colours[0], (Rgb8{255, 0, 0}));
  EXPECT_THAT(model->warnings,
              ElementsAre(AllOf(HasSubstr("texture 1 of 1 is left out"),
                                HasSubstr("no PNG, JPEG or WebP"),
                                HasSubstr("convert it"))));
}

TEST(ParseObjModel, TexturesPaintCorners) {
  for (const std::string& picture :
       {*image_codec::EncodePng(ColourImage(4, 4, Rgb8{9, 80, 200})),
        *image_codec::EncodeJpeg(ColourImage(8, 8, Rgb8{9, 80, 200}), 98)}) {
    const auto beside = [&](const std::string& name) -> std::optional<std::string> {
      if (name == "wedge.mtl") return "newmtl red\nKd 1 0 0\nmap_Kd wood\n";
      return picture;
    };
    const Result<FurnitureModel> model =
        ParseObjModel(kWedge, beside, Eigen::Matrix3d::Identity(), CatalogueSize{1, 1, 1});
    ASSERT_TRUE(model.ok()) << model.error().message;
    EXPECT_THAT(model->warnings, IsEmpty());
    EXPECT_NEAR(model->mesh.colours[0].r, 9, 2);
    EXPECT_NEAR(model->mesh.colours[0].g, 80, 2);
    EXPECT_NEAR(model->mesh.colours[0].b, 200, 2);
  }
}

TEST(ParseObjModel, KeepsTheFilesOwnSizeWhenNoneIsGiven) {
  const Result<FurnitureModel> model =
      ParseObjModel(kWedge, Materials, Eigen::Matrix3d::Identity(), std::nullopt);
  ASSERT_TRUE(model.ok());
  // x 2, y 4 (up), z 1 (front) in the file.
  EXPECT_LT((model->size_m - Eigen::Vector3d(1, 2, 4)).norm(), 1e-6);
}

TEST(ParseObjModel, GlassAndChromeAreShiny) {
  const auto shiny = [](const std::string& material) {
    const auto beside = [&](const std::string&) -> std::optional<std::string> {
      return "newmtl red\n" + material;
    };
    const Result<FurnitureModel> model =
        ParseObjModel(kWedge, beside, Eigen::Matrix3d::Identity(), CatalogueSize{1, 1, 1});
    return model->shiny.at(0) != 0;
  };
  EXPECT_TRUE(shiny("Kd 0.8 0.9 0.9\nd 0.2\n"));
  EXPECT_TRUE(shiny("Kd 0.1 0.1 0.1\nKs 1 1 1\nNs 400\n"));
  EXPECT_FALSE(shiny("Kd 0.6 0.5 0.4\nKs 0.5 0.5 0.5\nNs 96\n"));
}

TEST(ParseObjModel, RefusesWhatIsNoModel) {
  const auto refusal = [](const std::string& obj,
                          const CatalogueSize& size = CatalogueSize{1, 1, 1}) {
    const Result<FurnitureModel> model =
        ParseObjModel(obj, Nothing, Eigen::Matrix3d::Identity(), size);
    return model.ok() ? std::string() : model.error().message;
  };
  EXPECT_THAT(refusal(""), HasSubstr("no faces"));
  EXPECT_THAT(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), HasSubstr("flat"));
  EXPECT_NE(refusal("v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 9\n"), "");
  EXPECT_NE(refusal("\x01\x02 nonsense f 1 2 3"), "");
  EXPECT_THAT(refusal(kWedge, {0, 1, 1}), HasSubstr("not a size"));
  EXPECT_THAT(refusal(kWedge, {1, std::numeric_limits<double>::quiet_NaN(), 1}),
              HasSubstr("not a size"));
}

}  // namespace
}  // namespace deepslam::synth
