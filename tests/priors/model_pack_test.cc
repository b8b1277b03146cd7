#include "deepslam/priors/model_pack.h"

#include <cstring>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/core/sha256.h"
#include "deepslam/furniture/design.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::priors {
namespace {

PackedModel Chair(int number) {
  furniture::Design design = furniture::MakeDesign(
      furniture::Kind::kChair, Random(3, "pack", static_cast<unsigned>(number)));
  PackedModel model{"scopia/chair" + std::to_string(number),
                    "chair",
                    "catalogue",
                    number == 0 ? "withheld" : "train",
                    "Chair by Zo\xc3\xab, CC-BY",
                    number == 1,
                    std::move(design.mesh)};
  return model;
}

PackedModel ColouredChair() {
  PackedModel model = Chair(2);
  Random random(4, "colours", 0);
  for (std::size_t n = 0; n < model.mesh.vertices.size(); ++n) {
    model.mesh.colours.push_back({static_cast<std::uint8_t>(random.Index(256)),
                                  static_cast<std::uint8_t>(n % 2 == 0 ? 0 : 255),
                                  static_cast<std::uint8_t>(random.Index(256))});
  }
  return model;
}

ModelPack SomePack() {
  ModelPack pack;
  pack.models = {Chair(0), Chair(1), ColouredChair()};
  pack.withheld = {*shape::Voxelize(pack.models[0].mesh), VoxelGrid()};
  return pack;
}

// As if the file had been made so: damage that a checksum does not see.
std::string Sealed(std::string content) { return content + Sha256Hex(content); }
std::string Content(const std::string& bytes) { return bytes.substr(0, bytes.size() - 64); }

TEST(ModelPackTest, FacesComeBackWhereTheyWere) {
  const ModelPack pack = SomePack();
  const Result<std::string> bytes = EncodeModelPack(pack);
  ASSERT_TRUE(bytes.ok());
  const Result<ModelPack> read = DecodeModelPack(*bytes);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->models.size(), pack.models.size());
  EXPECT_EQ(read->withheld, pack.withheld);
  for (std::size_t m = 0; m < pack.models.size(); ++m) {
    const PackedModel& before = pack.models[m];
    const PackedModel& after = read->models[m];
    EXPECT_EQ(after.id, before.id);
    EXPECT_EQ(after.class_name, before.class_name);
    EXPECT_EQ(after.source, before.source);
    EXPECT_EQ(after.split, before.split);
    EXPECT_EQ(after.credit, before.credit);
    EXPECT_EQ(after.between_arms, before.between_arms);
    ASSERT_EQ(after.mesh.faces.size(), before.mesh.faces.size());
    EXPECT_LE(after.mesh.vertices.size(), before.mesh.vertices.size());
    ASSERT_EQ(after.mesh.colours.empty(), before.mesh.colours.empty());
    for (std::size_t f = 0; f < before.mesh.faces.size(); ++f) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t old_corner = before.mesh.faces[f][c];
        const std::uint32_t new_corner = after.mesh.faces[f][c];
        // Half a step of a box of at most 2 m.
        EXPECT_LT((after.mesh.vertices[new_corner] - before.mesh.vertices[old_corner]).norm(),
                  5e-5f);
        if (before.mesh.colours.empty()) continue;
        const Rgb8 was = before.mesh.colours[old_corner];
        const Rgb8 is = after.mesh.colours[new_corner];
        EXPECT_NEAR(is.r, was.r, 3);
        EXPECT_EQ(is.g, was.g);  // black and white stay
        EXPECT_NEAR(is.b, was.b, 3);
      }
    }
  }
}

TEST(ModelPackTest, WhatIsPackedTwiceIsTheSame) {
  const Result<std::string> once = EncodeModelPack(SomePack());
  ASSERT_TRUE(once.ok());
  const Result<std::string> twice = EncodeModelPack(*DecodeModelPack(*once));
  ASSERT_TRUE(twice.ok());
  const Result<ModelPack> a = DecodeModelPack(*once);
  const Result<ModelPack> b = DecodeModelPack(*twice);
  ASSERT_TRUE(a.ok() && b.ok());
  for (std::size_t m = 0; m < a->models.size(); ++m) {
    EXPECT_EQ(a->models[m].mesh.faces, b->models[m].mesh.faces);
    EXPECT_EQ(a->models[m].mesh.colours, b->models[m].mesh.colours);
  }
}

TEST(ModelPackTest, DamageIsNamed) {
  const std::string bytes = *EncodeModelPack(SomePack());
  for (std::size_t length = 0; length < bytes.size(); length += 997)
    EXPECT_FALSE(DecodeModelPack(std::string_view(bytes).substr(0, length)).ok()) << length;
  for (std::size_t at = 0; at < bytes.size(); at += 4999) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    EXPECT_FALSE(DecodeModelPack(changed).ok()) << at;
  }
  std::string newer = bytes;
  newer[8] = 9;
  const Result<ModelPack> read = DecodeModelPack(newer);
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("version 9"), std::string::npos) << read.error().message;
}

// Sealed with a checksum of its own: nothing is read past the end, and no memory is asked for that
// the file does not bear out.
TEST(ModelPackTest, HostileContentIsRefused) {
  const std::string content = Content(*EncodeModelPack(SomePack()));
  for (std::size_t length = 8; length < content.size(); length += 1009)
    EXPECT_FALSE(DecodeModelPack(Sealed(content.substr(0, length))).ok()) << length;
  for (std::size_t at = 12; at < 400; ++at) {
    std::string changed = content;
    changed[at] = static_cast<char>(0xFF);
    // A name or a size may change and still be one; what comes back is whole.
    const Result<ModelPack> read = DecodeModelPack(Sealed(changed));
    if (!read) continue;
    for (const PackedModel& model : read->models) {
      for (const auto& face : model.mesh.faces) {
        for (const std::uint32_t corner : face) ASSERT_LT(corner, model.mesh.vertices.size());
      }
    }
  }
  EXPECT_FALSE(DecodeModelPack(Sealed(content + "more")).ok());
}

TEST(ModelPackTest, BadMeshesAreNotPacked) {
  ModelPack pack;
  pack.models = {Chair(1)};
  pack.models[0].mesh.vertices[5].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(EncodeModelPack(pack).ok());
  pack.models = {Chair(1)};
  pack.models[0].mesh.faces[2][1] = 1'000'000;
  EXPECT_FALSE(EncodeModelPack(pack).ok());
  pack.models = {Chair(1)};
  pack.models[0].credit.assign(70'000, 'x');
  EXPECT_FALSE(EncodeModelPack(pack).ok());
}

}  // namespace
}  // namespace deepslam::priors
