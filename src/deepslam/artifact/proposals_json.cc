#include "deepslam/artifact/proposals_json.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <ranges>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/candidates", 2};
constexpr std::size_t kMaxLatents = 4096;  // files of more are refused; decoders take far fewer
constexpr Range kLatent{-1e6, 1e6};

namespace {

void DescribeMeasuredPlace(JsonVisitor& visitor, std::optional<Similarity3>& world_from_object) {
  Similarity3 place = world_from_object.value_or(Similarity3{});
  Pose3 rigid = place.RigidPart();
  const bool has_pose = visitor.Maybe("world_from_object", rigid, world_from_object.has_value());
  const bool has_scale =
      visitor.Maybe("scale_m", place.scale, world_from_object.has_value(), kSizeM);
  if (!visitor.reading()) return;
  if (has_pose != has_scale) visitor.Fail({}, "has one of world_from_object and scale_m alone");
  if (has_scale && !(place.scale > 0)) visitor.Fail("scale_m", "must be positive");
  if (has_pose) world_from_object = Similarity3::From(rigid, place.scale);
}

}  // namespace

void Describe(JsonVisitor& visitor, ShapeCandidate& candidate) {
  visitor.Field("id", candidate.id);
  visitor.Field("object", candidate.object);
  visitor.Field("source", candidate.source);
  visitor.Maybe("view", candidate.view);
  visitor.Field("model", candidate.model);
  visitor.Field("proposal_score", candidate.proposal_score);
  visitor.Field("size_m", candidate.size_m, kSizeM);
  visitor.Field("min_size_m", candidate.min_size_m, kSizeM);
  visitor.Field("max_size_m", candidate.max_size_m, kSizeM);
  DescribeMeasuredPlace(visitor, candidate.world_from_object);
  visitor.Field("latents", candidate.latents, kLatent);
  if (candidate.latents.size() > kMaxLatents)
    visitor.Fail({}, fmt::format("has more than {} latents", kMaxLatents));
  visitor.Field("library_id", candidate.library_id);
  visitor.Field("credit", candidate.credit);
  visitor.Field("stretch", candidate.stretch);
  if (!(candidate.stretch.array() > 0).all()) visitor.Fail("stretch", "must be positive");
}

namespace {

void DescribeModels(JsonVisitor& visitor, std::map<std::string, VoxelGrid>& models) {
  std::vector<std::string> keys;
  if (visitor.writing()) std::ranges::copy(std::views::keys(models), std::back_inserter(keys));
  visitor.Field("models", keys);
  for (std::size_t n = 0; visitor.reading() && n < keys.size(); ++n) {
    if (!IsModelKey(keys[n]))
      visitor.Fail(fmt::format("models[{}]", n), fmt::format("\"{}\" is no model key", keys[n]));
    models.emplace(std::move(keys[n]), VoxelGrid{{}});
  }
}

}  // namespace

void Describe(JsonVisitor& visitor, Proposals& proposals) {
  DescribeModels(visitor, proposals.models);
  visitor.Field("candidates", proposals.candidates);
  for (std::size_t n = 0; visitor.reading() && n < proposals.candidates.size(); ++n) {
    if (!proposals.models.contains(proposals.candidates[n].model))
      visitor.Fail(fmt::format("candidates[{}]", n), "names a model that is not listed");
  }
  visitor.Field("notes", proposals.notes);
}

bool IsModelKey(std::string_view key) {
  return !key.empty() && key.size() <= 200 && key.front() != '.' &&
         std::all_of(key.begin(), key.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-' || c == '.';
         });
}

Result<std::string> EncodeProposals(const Proposals& proposals, std::string_view name) {
  for (const auto& [key, grid] : proposals.models) {
    if (!IsModelKey(key)) return Failed(fmt::format("{}: \"{}\" cannot be a file name", name, key));
  }
  return EncodeDocument(kFormat, proposals, name);
}

Result<Proposals> DecodeProposals(TextSource text, std::string_view name) {
  return DecodeDocument<Proposals>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
