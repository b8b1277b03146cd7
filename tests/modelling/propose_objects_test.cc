#include "deepslam/modelling/propose_objects.h"

#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modelling/furnished_room.h"

namespace deepslam::modelling {
namespace {

using ::deepslam::testing_support::ChairGrid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing_support::Frames;
using testing_support::Furniture;
using testing_support::ModelledRoom;

const Furniture kChair = {"chair", ChairGrid(), 0.9, 0.0, -0.3, 0.4};
const Furniture kOther = {"chair", ChairGrid(), 0.9, -0.5, 0.8, 2.2};

// As many candidates as the object has views.
class OnePerView final : public propose::Proposer {
 public:
  explicit OnePerView(std::string name) : name_(std::move(name)) {}
  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] Result<Proposals> Propose(
      const propose::ObjectObservations& object) const override {
    if (fails) return Failed("out of ideas");
    Proposals proposals;
    for (const ObjectView& view : object.views) {
      ShapeCandidate candidate;
      candidate.object = object.id;
      candidate.view = view.detection;
      candidate.model = name_ + std::to_string(object.id.value);
      proposals.candidates.push_back(candidate);
      proposals.models.emplace(candidate.model, ChairGrid());
    }
    proposals.notes.push_back(object.cloud == nullptr ? "blind" : "with depth");
    return proposals;
  }
  bool fails = false;

 private:
  std::string name_;
};

class ProposeObjectsTest : public testing::Test {
 protected:
  ProposeObjectsTest() {
    for (const char* const name : {"a", "b"}) {
      auto proposer = std::make_unique<OnePerView>(name);
      proposers_.push_back(proposer.get());
      sources_.proposers.push_back(std::move(proposer));
    }
    room_.Track(0, 0, Frames(0, 2));
    room_.Track(1, 1, Frames(0, 3));
  }

  [[nodiscard]] Result<Proposals> Propose() {
    return ProposeObjects(room_.Objects(), sources_, room_.Views(), room_.progress);
  }

  ModelledRoom room_{{kChair, kOther}};
  std::vector<OnePerView*> proposers_;
  CandidateSources sources_;
};

TEST_F(ProposeObjectsTest, OfEveryObjectInTurnFromEverySource) {
  const Result<Proposals> proposals = Propose();
  ASSERT_TRUE(proposals.ok());
  std::string models;
  for (std::size_t n = 0; n < proposals->candidates.size(); ++n) {
    EXPECT_EQ(proposals->candidates[n].id, CandidateId{static_cast<int>(n)});
    models += proposals->candidates[n].model + " ";
  }
  EXPECT_EQ(models, "a0 a0 b0 b0 a1 a1 a1 b1 b1 b1 ");
  EXPECT_EQ(proposals->models.size(), 4U);
  EXPECT_EQ(proposals->notes.front(), "chair_00: with depth");
}

TEST_F(ProposeObjectsTest, ByColourAloneNobodyIsGivenDepthsPoints) {
  sources_.use_depth = false;
  EXPECT_EQ(Propose()->notes.front(), "chair_00: blind");
}

TEST_F(ProposeObjectsTest, AnObjectWithoutViewsGetsANote) {
  room_.room.broken = {0, 1, 2};
  const Result<Proposals> proposals = Propose();
  ASSERT_TRUE(proposals.ok());
  EXPECT_TRUE(proposals->candidates.empty());
  EXPECT_THAT(proposals->notes,
              ElementsAre("chair_00: no view could be read", "chair_01: no view could be read"));
}

TEST_F(ProposeObjectsTest, TheErrorOfASourceNamesIt) {
  proposers_[1]->fails = true;
  EXPECT_EQ(Propose().error().message, "source b: out of ideas");
}

TEST_F(ProposeObjectsTest, EndsWhenAskedTo) {
  room_.progress.stop = true;
  EXPECT_EQ(Propose().error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace deepslam::modelling
