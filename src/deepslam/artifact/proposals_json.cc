#include "deepslam/artifact/proposals_json.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/candidates";
constexpr int kVersion = 2;
constexpr std::size_t kMaxLatents = 4096;

JsonValue CandidateToJson(const ShapeCandidate& candidate) {
  JsonArray latents;
  // A float's own shortest form would read back as another double; the double of the float reads
  // back as the float.
  for (const float latent : candidate.latents) latents.emplace_back(latent);
  JsonObject row;
  row.emplace("id", ToJson(candidate.id));
  row.emplace("object", ToJson(candidate.object));
  row.emplace("source", NameOf(candidate.source));
  row.emplace("view", ToJson(candidate.view));
  row.emplace("model", candidate.model);
  row.emplace("proposal_score", candidate.proposal_score);
  row.emplace("size_m", candidate.size_m);
  row.emplace("min_size_m", candidate.min_size_m);
  row.emplace("max_size_m", candidate.max_size_m);
  row.emplace("latents", std::move(latents));
  row.emplace("library_id", candidate.library_id);
  row.emplace("credit", candidate.credit);
  row.emplace("stretch", ToJson(candidate.stretch));
  return JsonValue(std::move(row));
}

ShapeCandidate ReadCandidate(const JsonNode& row) {
  ShapeCandidate candidate;
  candidate.id = ReadId<CandidateId>(row["id"]);
  candidate.object = ReadId<ObjectId>(row["object"]);
  candidate.source = ReadCandidateSource(row["source"]);
  candidate.view = ReadId<DetectionId>(row.Maybe("view"));
  candidate.model = row["model"].String();
  candidate.proposal_score = row["proposal_score"].Number();
  candidate.size_m = row["size_m"].Number(0, 1e3);
  candidate.min_size_m = row["min_size_m"].Number(0, 1e3);
  candidate.max_size_m = row["max_size_m"].Number(0, 1e3);
  const std::vector<JsonNode> latents = row["latents"].Items();
  if (latents.size() > kMaxLatents) row.Fail(fmt::format("has more than {} latents", kMaxLatents));
  for (const JsonNode& latent : latents)
    candidate.latents.push_back(static_cast<float>(latent.Number(-1e6, 1e6)));
  candidate.library_id = row["library_id"].String();
  candidate.credit = row["credit"].String();
  candidate.stretch = ReadVector3(row["stretch"]);
  if (!(candidate.stretch.array() > 0).all()) row["stretch"].Fail("must be positive");
  return candidate;
}

}  // namespace

bool IsModelKey(std::string_view key) {
  return !key.empty() && key.size() <= 200 && key.front() != '.' &&
         std::all_of(key.begin(), key.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-' || c == '.';
         });
}

Result<std::string> EncodeProposals(const Proposals& proposals, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  JsonArray candidates;
  for (const ShapeCandidate& candidate : proposals.candidates)
    candidates.push_back(CandidateToJson(candidate));
  JsonArray models;
  for (const auto& [key, grid] : proposals.models) {
    if (!IsModelKey(key)) return Failed(fmt::format("{}: \"{}\" cannot be a file name", name, key));
    models.emplace_back(key);
  }
  JsonArray notes;
  for (const std::string& note : proposals.notes) notes.emplace_back(note);
  document.emplace("candidates", std::move(candidates));
  document.emplace("models", std::move(models));
  document.emplace("notes", std::move(notes));
  return DumpJson(std::move(document), name);
}

Result<Proposals> DecodeProposals(TextSource text, std::string_view name) {
  JsonReader reader(std::move(text), name, kFormat, kVersion);
  const JsonNode root = reader.root();
  Proposals proposals;
  for (const JsonNode& node : root["models"].Items()) {
    std::string key = node.String();
    if (!IsModelKey(key)) node.Fail(fmt::format("\"{}\" is no model key", key));
    proposals.models.emplace(std::move(key), VoxelGrid{{}});
    if (!reader.ok()) break;
  }
  for (const JsonNode& row : root["candidates"].Items()) {
    proposals.candidates.push_back(ReadCandidate(row));
    if (!proposals.models.contains(proposals.candidates.back().model))
      row.Fail("names a model that is not listed");
  }
  for (const JsonNode& node : root["notes"].Items()) proposals.notes.push_back(node.String());
  return reader.Finish(std::move(proposals));
}

}  // namespace deepslam::artifact
