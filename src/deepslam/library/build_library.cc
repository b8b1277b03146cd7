#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/library/canonical.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/library/classify.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/library/library_files.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/shape/distance_transform.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::library {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPropertiesBytes = 16U << 20U;
constexpr std::size_t kMaxObjBytes = 256U << 20U;

// A catalogue item of a mapped class, and what became of it.
struct Entry {
  CatalogueItem item;
  std::string class_name;
  LibraryModel model;
  bool withheld = false;
  std::string dropped;  // reason; empty = in
};

struct OpenCatalogue {
  ZipArchive archive;
  Catalogue catalogue;
};

// "Kator Legaz#bar-stool" -> "kator_legaz/bar-stool".
std::string LibraryId(std::string_view catalogue_id) {
  const std::size_t hash = std::min(catalogue_id.find('#'), catalogue_id.size());
  std::string id;
  for (std::size_t n = 0; n < catalogue_id.size(); ++n) {
    const char c = catalogue_id[n];
    const bool plain = (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '-' || c == '_';
    if (n == hash) {
      id.push_back('/');
    } else if (plain) {
      id.push_back(n < hash ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : c);
    } else {
      id.push_back('_');
    }
  }
  return hash < catalogue_id.size() ? id : "unnamed/" + id;
}

Result<std::vector<fs::path>> CatalogueFiles(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == ".sh3f") files.push_back(it->path());
  }
  if (error) return InvalidInput(folder.string() + ": cannot be read (" + error.message() + ")");
  if (files.empty()) {
    return InvalidInput(folder.string() +
                        ": holds no *.sh3f catalogue; install the package sweethome3d-furniture");
  }
  std::sort(files.begin(), files.end());
  return files;
}

Result<OpenCatalogue> ReadCatalogue(const fs::path& file) {
  Result<ZipArchive> archive = ZipArchive::Open(file);
  if (!archive) return archive.error();
  const Result<std::string> bytes =
      archive->Read("PluginFurnitureCatalog.properties", kMaxPropertiesBytes);
  if (!bytes) return bytes.error();
  Result<Catalogue> catalogue = ParseCatalogue(*bytes);
  if (!catalogue) return InvalidInput(file.string() + ": " + catalogue.error().message);
  return OpenCatalogue{std::move(*archive), std::move(*catalogue)};
}

void FillModel(const Result<std::string>& bytes, Entry& entry) {
  if (!bytes) {
    entry.dropped = bytes.error().message;
    return;
  }
  const Result<TriangleMesh> mesh = ReadObj(*bytes);
  if (!mesh) {
    entry.dropped = mesh.error().message;
    return;
  }
  const Result<CanonicalModel> canonical = MakeCanonical(*mesh, entry.item, entry.class_name);
  if (!canonical) {
    entry.dropped = canonical.error().message;
    return;
  }
  entry.model.shape = canonical->shape;
  entry.model.size_m = canonical->size_m;
}

// Archives are read by one thread; meshes are big, so only a few are held at once.
Status FillModels(const ZipArchive& archive, std::vector<Entry>& entries, Progress& progress) {
  constexpr std::size_t kBatch = 8;
  for (std::size_t begin = 0; begin < entries.size(); begin += kBatch) {
    if (progress.StopRequested()) return Interrupted();
    const std::size_t count = std::min(kBatch, entries.size() - begin);
    std::vector<Result<std::string>> meshes;
    for (std::size_t n = 0; n < count; ++n) {
      meshes.push_back(archive.Read(entries[begin + n].item.model, kMaxObjBytes));
    }
    ParallelFor(count, [&](std::size_t n) {
      Entry& entry = entries[begin + n];
      if (entry.dropped.empty()) FillModel(meshes[n], entry);
    });
  }
  return Ok();
}

std::vector<Entry> EntriesOf(const Catalogue& catalogue, const std::vector<std::string>& withheld) {
  std::vector<Entry> entries;
  for (const CatalogueItem& item : catalogue.items) {
    const std::optional<std::string> class_name = ClassOfItem(item);
    const bool is_withheld = std::find(withheld.begin(), withheld.end(), item.id) != withheld.end();
    if (!class_name && !is_withheld) continue;
    Entry entry = {item, class_name.value_or(""), {}, is_withheld, item.fault};
    entry.model.id = LibraryId(item.id);
    entry.model.name = item.name;
    entry.model.class_name = entry.class_name;
    entry.model.creator = item.creator;
    entry.model.licence = catalogue.licence;
    entries.push_back(std::move(entry));
  }
  return entries;
}

bool SameProduct(const Entry& a, const Entry& b) {
  constexpr double kSameShape = 0.95;
  constexpr double kSameSize = 0.05;
  const Eigen::Array3d ratio = a.model.size_m.array() / b.model.size_m.array();
  return a.class_name == b.class_name && (ratio - 1.0).abs().maxCoeff() < kSameSize &&
         shape::GridIntersectionOverUnion(a.model.shape, b.model.shape) > kSameShape;
}

// Marks what must not enter: withheld products, shapes like theirs, ids and shapes that are there
// already.
void DropUnwanted(std::vector<Entry>& entries) {
  std::vector<const Entry*> withheld;
  for (const Entry& entry : entries) {
    if (entry.withheld && entry.dropped.empty()) withheld.push_back(&entry);
  }
  ParallelFor(entries.size(), [&](std::size_t n) {
    Entry& entry = entries[n];
    if (!entry.dropped.empty() || entry.withheld) return;
    for (const Entry* other : withheld) {
      if (!ShapesAlike(other->model.shape, entry.model.shape)) continue;
      entry.dropped = "shape like the withheld " + other->item.id;
      return;
    }
  });
  std::vector<const Entry*> kept;
  std::set<std::string> ids;
  for (Entry& entry : entries) {
    if (!entry.dropped.empty() || entry.withheld) continue;
    for (const Entry* other : kept) {
      if (!entry.dropped.empty()) break;
      if (SameProduct(*other, entry)) entry.dropped = "same shape and size as " + other->item.id;
    }
    if (entry.dropped.empty() && !ids.insert(entry.model.id).second)
      entry.dropped = "id not unique";
    if (entry.dropped.empty()) kept.push_back(&entry);
  }
  for (Entry& entry : entries) {
    if (entry.withheld) entry.dropped = "withheld";
  }
}

Status CheckWithheldFound(const std::vector<Entry>& entries,
                          const std::vector<std::string>& withheld) {
  for (const std::string& id : withheld) {
    const auto it = std::find_if(
        entries.begin(), entries.end(), [&](const Entry& entry) { return entry.item.id == id; });
    if (it == entries.end()) {
      return InvalidConfig("withheld model '" + id + "' is in none of the catalogues");
    }
    if (!it->dropped.empty()) {
      return InvalidConfig("withheld model '" + id + "' cannot be read: " + it->dropped);
    }
  }
  return Ok();
}

constexpr double kAlike = 0.9;
// Legs and boards are one or two voxels thick: a different rounding halves their overlap. So shapes
// are alike as well when nearly all of each lies within a voxel of the other.
constexpr double kNearlyAll = 0.97;
constexpr float kNearSquared = 2.0F;  // diagonal neighbours in a plane

// Share of a's voxels that lie within a voxel of the shape whose squared distances are given.
double ShareNear(const VoxelGrid& a, const std::vector<float>& squared_distance_b) {
  std::size_t near = 0;
  std::size_t all = 0;
  for (std::size_t n = 0; n < a.occupied.size(); ++n) {
    if (a.occupied[n] == 0) continue;
    ++all;
    near += squared_distance_b[n] <= kNearSquared ? 1U : 0U;
  }
  return all > 0 ? static_cast<double>(near) / static_cast<double>(all) : 0.0;
}

// Occupied share of the model's own box.
double Fullness(const VoxelGrid& grid, const Eigen::Vector3d& extent) {
  const auto count = std::count(grid.occupied.begin(), grid.occupied.end(), std::uint8_t{1});
  return static_cast<double>(count) * kVoxelSize * kVoxelSize * kVoxelSize / extent.prod();
}

}  // namespace

bool ShapesAlike(const VoxelGrid& a, const VoxelGrid& b) {
  const Eigen::Vector3d extent_a = shape::ShapeModel(a).extent().cast<double>();
  const Eigen::Vector3d extent_b = shape::ShapeModel(b).extent().cast<double>();
  if (extent_a.minCoeff() <= 0 || extent_b.minCoeff() <= 0) return false;
  // A first look that costs nothing.
  constexpr double kOtherFullness = 1.5;
  const double ratio = Fullness(a, extent_a) / Fullness(b, extent_b);
  if (ratio > kOtherFullness || ratio < 1.0 / kOtherFullness) return false;
  const std::vector<float> squared_distance_a = shape::SquaredDistanceTo(a, true);
  for (int turns = 0; turns < 4; ++turns) {
    Eigen::Vector3d extent_turned = extent_b;
    if (turns % 2 != 0) std::swap(extent_turned.x(), extent_turned.y());
    const VoxelGrid fitted =
        shape::StretchGrid(shape::TurnGrid(b, turns), extent_a.cwiseQuotient(extent_turned));
    if (shape::GridIntersectionOverUnion(a, fitted) > kAlike) return true;
    if (ShareNear(fitted, squared_distance_a) > kNearlyAll &&
        ShareNear(a, shape::SquaredDistanceTo(fitted, true)) > kNearlyAll) {
      return true;
    }
  }
  return false;
}

Result<LibrarySummary> BuildLibrary(const BuildLibraryOptions& options, Progress& progress) {
  const Result<std::vector<fs::path>> files = CatalogueFiles(options.catalogues);
  if (!files) return files.error();
  LibrarySummary summary;
  std::vector<Entry> entries;
  std::map<std::string, std::string> licences;
  for (std::size_t n = 0; n < files->size(); ++n) {
    if (progress.StopRequested()) return Interrupted();
    progress.Report(n, files->size());
    const Result<OpenCatalogue> open = ReadCatalogue((*files)[n]);
    if (!open) return open.error();
    summary.num_catalogue_items += static_cast<int>(open->catalogue.items.size());
    std::vector<Entry> found = EntriesOf(open->catalogue, options.withheld);
    if (const Status status = FillModels(open->archive, found, progress); !status) {
      return status.error();
    }
    constexpr std::size_t kMaxLicenceBytes = 1U << 20U;
    const Result<std::string> licence = open->archive.Read("LICENSE.TXT", kMaxLicenceBytes);
    licences[open->catalogue.name] =
        open->catalogue.licence + "\n" + (licence ? *licence : std::string());
    std::move(found.begin(), found.end(), std::back_inserter(entries));
  }
  if (const Status status = CheckWithheldFound(entries, options.withheld); !status) {
    return status.error();
  }
  DropUnwanted(entries);
  ModelLibrary library;
  for (Entry& entry : entries) {
    if (!entry.dropped.empty()) {
      summary.dropped.push_back(entry.item.id + ": " + entry.dropped);
      continue;
    }
    ++summary.per_class[entry.class_name];
    library.models.push_back(std::move(entry.model));
  }
  std::sort(library.models.begin(),
            library.models.end(),
            [](const LibraryModel& a, const LibraryModel& b) { return a.id < b.id; });
  if (const Status status = WriteLibrary(library, licences, options.out); !status) {
    return status.error();
  }
  progress.Report(files->size(), files->size());
  summary.checksum = library.checksum;
  return summary;
}

}  // namespace deepslam::library
