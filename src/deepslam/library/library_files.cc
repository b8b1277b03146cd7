#include "deepslam/library/library_files.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/shape/binvox.h"

namespace deepslam::library {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr std::string_view kFormatName = "deepslam-furniture";
constexpr int kFormatVersion = 1;  // raised when the list's fields or the models' grid change
constexpr std::string_view kRemedy = "; make it again with 'deepslam library build'";
constexpr std::uintmax_t kMaxJsonBytes = 64U << 20U;
constexpr std::uintmax_t kMaxModelBytes =
    2U << 20U;                              // run lengths of 64^3 voxels at worst, and the header
constexpr std::size_t kMaxModels = 100000;  // bounds memory; files of more are refused

std::string FileOf(const LibraryModel& model) {
  std::string file = model.id;
  if (const std::size_t slash = file.find('/'); slash != std::string::npos) {
    file.replace(slash, 1, "__");
  }
  return "models/" + file + ".binvox";
}

bool IsModelId(std::string_view id) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '/';
  };
  constexpr std::size_t kMaxLength = 200;  // characters; it becomes the name of a file
  return !id.empty() && id.size() <= kMaxLength && std::all_of(id.begin(), id.end(), is_plain) &&
         std::count(id.begin(), id.end(), '/') == 1 && id.front() != '/' && id.back() != '/';
}

Status WriteFile(const fs::path& file, std::string_view bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) return Failed(file.string() + ": cannot be written; is the disk full or read-only?");
  return Ok();
}

Result<std::string> ReadFile(const fs::path& file, std::uintmax_t max_bytes) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) return InvalidInput(file.string() + ": cannot be read" + std::string(kRemedy));
  if (size > max_bytes) return InvalidInput(file.string() + ": too large for a library's file");
  std::ifstream in(file, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) return InvalidInput(file.string() + ": cannot be read");
  return bytes;
}

Json ModelJson(const LibraryModel& model) {
  return {{"id", model.id},
          {"name", model.name},
          {"class", model.class_name},
          {"size_m", {model.size_m.x(), model.size_m.y(), model.size_m.z()}},
          {"creator", model.creator},
          {"licence", model.licence},
          {"checksum", model.checksum},
          {"file", FileOf(model)}};
}

std::string LibraryChecksum(const Json& models) { return Sha256Hex(models.dump()); }

std::string LicenceFile(const ModelLibrary& library,
                        const std::map<std::string, std::string>& licence_texts) {
  std::string text =
      "The models of this library were made from furniture meshes of Sweet Home 3D catalogues, "
      "turned\n"
      "into 64^3 voxels. Whoever publishes a scene with such a model has to pass its credit "
      "on.\n\n";
  for (const LibraryModel& model : library.models)
    text += model.id + ": " + CreditLine(model) + "\n";
  for (const auto& [catalogue, licence] : licence_texts) {
    text += "\n---- " + catalogue + " ----\n" + licence + "\n";
  }
  return text;
}

Status WriteContents(ModelLibrary& library,
                     const std::map<std::string, std::string>& licence_texts,
                     const fs::path& folder) {
  Json models = Json::array();
  for (LibraryModel& model : library.models) {
    const std::string bytes = shape::WriteBinvox(model.shape);
    model.checksum = Sha256Hex(bytes);
    if (const Status status = WriteFile(folder / FileOf(model), bytes); !status) return status;
    models.push_back(ModelJson(model));
  }
  library.checksum = LibraryChecksum(models);
  const Json root = {{"format", kFormatName},
                     {"version", kFormatVersion},
                     {"checksum", library.checksum},
                     {"models", std::move(models)}};
  if (const Status status = WriteFile(folder / "LICENSES.txt", LicenceFile(library, licence_texts));
      !status) {
    return status;
  }
  return WriteFile(folder / "library.json", root.dump(1) + "\n");
}

// The fields of one entry; throws Json exceptions for missing or mistyped ones.
LibraryModel ModelFields(const Json& entry) {
  LibraryModel model;
  model.id = entry.at("id").get<std::string>();
  model.name = entry.at("name").get<std::string>();
  model.class_name = entry.at("class").get<std::string>();
  const auto size_m = entry.at("size_m").get<std::array<double, 3>>();
  model.size_m = {size_m[0], size_m[1], size_m[2]};
  model.creator = entry.at("creator").get<std::string>();
  model.licence = entry.at("licence").get<std::string>();
  model.checksum = entry.at("checksum").get<std::string>();
  return model;
}

Result<LibraryModel> ReadModel(const Json& entry, const fs::path& folder) {
  const std::string place = (folder / "library.json").string();
  LibraryModel model;
  try {
    model = ModelFields(entry);
  } catch (const Json::exception& error) {
    return InvalidInput(place + ": bad model entry (" + error.what() + ")" + std::string(kRemedy));
  }
  constexpr double kMaxModelSize_m = 50;  // as of a catalogue: larger numbers are in another unit
  const bool sized = model.size_m.allFinite() && model.size_m.minCoeff() > 0 &&
                     model.size_m.maxCoeff() < kMaxModelSize_m;
  if (!IsModelId(model.id) || !sized) {
    return InvalidInput(place + ": model '" + model.id + "' has a bad id or size" +
                        std::string(kRemedy));
  }
  const fs::path file = folder / FileOf(model);
  const Result<std::string> bytes = ReadFile(file, kMaxModelBytes);
  if (!bytes) return bytes.error();
  if (Sha256Hex(*bytes) != model.checksum) {
    return InvalidInput(file.string() + ": differs from its checksum in library.json" +
                        std::string(kRemedy));
  }
  Result<VoxelGrid> shape = shape::ReadBinvox(*bytes);
  if (!shape) return InvalidInput(file.string() + ": " + shape.error().message);
  model.shape = std::move(*shape);
  return model;
}

Result<Json> ReadIndex(const fs::path& folder) {
  const fs::path file = folder / "library.json";
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) {
    return InvalidInput(folder.string() +
                        ": holds no furniture library (no library.json); make one with "
                        "'deepslam library build --catalogues DIR --out DIR'");
  }
  const Result<std::string> bytes = ReadFile(file, kMaxJsonBytes);
  if (!bytes) return bytes.error();
  Json root = Json::parse(*bytes, nullptr, false);
  if (!root.is_object() || root.value("format", Json()) != Json(kFormatName)) {
    return InvalidInput(file.string() + ": is no index of a furniture library" +
                        std::string(kRemedy));
  }
  const Json version = root.value("version", Json());
  if (version != Json(kFormatVersion)) {
    return InvalidInput(file.string() + ": format version " + version.dump() +
                        ", this program reads " + std::to_string(kFormatVersion) +
                        std::string(kRemedy));
  }
  const bool complete = root.contains("models") && root["models"].is_array() &&
                        root["models"].size() <= kMaxModels && root.contains("checksum") &&
                        root["checksum"] == Json(LibraryChecksum(root["models"]));
  if (!complete) {
    return InvalidInput(file.string() + ": damaged, its list of models differs from its checksum" +
                        std::string(kRemedy));
  }
  return root;
}

}  // namespace

std::string CreditLine(const LibraryModel& model) {
  return model.name + " by " + (model.creator.empty() ? "unknown" : model.creator) + ", " +
         model.licence;
}

Status WriteLibrary(ModelLibrary& library,
                    const std::map<std::string, std::string>& licence_texts,
                    const fs::path& folder) {
  std::error_code error;
  const bool replaceable = !fs::exists(folder, error) || fs::is_empty(folder, error) ||
                           fs::is_regular_file(folder / "library.json", error);
  if (!replaceable || error) {
    return InvalidInput(folder.string() +
                        ": is not empty and no furniture library; name another folder");
  }
  fs::path aside = folder;
  if (!aside.has_filename()) aside = aside.parent_path();
  aside += ".partial";
  fs::remove_all(aside, error);
  fs::create_directories(aside / "models", error);
  if (error) return Failed(aside.string() + ": cannot be made (" + error.message() + ")");
  if (const Status status = WriteContents(library, licence_texts, aside); !status) {
    fs::remove_all(aside, error);
    return status;
  }
  fs::remove_all(folder, error);
  fs::rename(aside, folder, error);
  if (error) return Failed(folder.string() + ": cannot be replaced (" + error.message() + ")");
  return Ok();
}

Result<ModelLibrary> LoadLibrary(const fs::path& folder) {
  const Result<Json> root = ReadIndex(folder);
  if (!root) return root.error();
  ModelLibrary library;
  library.checksum = root->at("checksum").get<std::string>();
  const Json& entries = root->at("models");
  std::vector<std::optional<Result<LibraryModel>>> models(entries.size());
  ParallelFor(entries.size(),
              [&](std::size_t n) { models[n].emplace(ReadModel(entries[n], folder)); });
  for (std::optional<Result<LibraryModel>>& model : models) {
    if (!*model) return model->error();
    library.models.push_back(std::move(*model).value());
  }
  std::sort(library.models.begin(),
            library.models.end(),
            [](const LibraryModel& a, const LibraryModel& b) { return a.id < b.id; });
  const auto same = [](const LibraryModel& a, const LibraryModel& b) { return a.id == b.id; };
  if (std::adjacent_find(library.models.begin(), library.models.end(), same) !=
      library.models.end()) {
    return InvalidInput((folder / "library.json").string() + ": lists a model twice" +
                        std::string(kRemedy));
  }
  return library;
}

}  // namespace deepslam::library
