#include "deepslam/library/products.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/library/canonical.h"
#include "deepslam/library/classify.h"
#include "deepslam/library/zip_archive.h"

namespace deepslam::library {
namespace {

namespace fs = std::filesystem;

// 16 MiB of text; an archive that claims more is refused.
constexpr std::size_t kMaxPropertiesBytes = 16U << 20U;
// 256 MiB, of a mesh; an archive that claims more is refused.
constexpr std::size_t kMaxObjBytes = 256U << 20U;

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

void FillModel(const Result<std::string>& bytes, Product& product) {
  if (!bytes) {
    product.dropped = bytes.error().message;
    return;
  }
  const Result<TriangleMesh> mesh = ReadObj(*bytes);
  if (!mesh) {
    product.dropped = mesh.error().message;
    return;
  }
  const Result<CanonicalModel> canonical = MakeCanonical(*mesh, product.item, product.class_name);
  if (!canonical) {
    product.dropped = canonical.error().message;
    return;
  }
  product.model.shape = canonical->shape;
  product.model.size_m = canonical->size_m;
  product.quarter_turns = canonical->quarter_turns;
}

// Archives are read by one thread; meshes are big, so only a few are held at once.
Status FillModels(const ZipArchive& archive, std::vector<Product>& products, Progress& progress) {
  constexpr std::size_t kMeshesAtOnce = 8;  // a balance of memory and threads at work
  for (std::size_t begin = 0; begin < products.size(); begin += kMeshesAtOnce) {
    if (progress.StopRequested()) return Interrupted();
    const std::size_t count = std::min(kMeshesAtOnce, products.size() - begin);
    std::vector<Result<std::string>> meshes;
    for (std::size_t n = 0; n < count; ++n) {
      meshes.push_back(archive.Read(products[begin + n].item.model, kMaxObjBytes));
    }
    ParallelFor(count, [&](std::size_t n) {
      Product& product = products[begin + n];
      if (product.dropped.empty()) FillModel(meshes[n], product);
    });
  }
  return Ok();
}

std::vector<Product> ProductsOf(const Catalogue& catalogue,
                                const std::string& file,
                                const std::vector<std::string>& wanted,
                                const std::vector<std::string>& classes) {
  std::vector<Product> products;
  for (const CatalogueItem& item : catalogue.items) {
    const std::optional<std::string> class_name = ClassOfItem(item);
    const bool other_class =
        !classes.empty() && class_name &&
        std::find(classes.begin(), classes.end(), *class_name) == classes.end();
    const bool is_wanted = std::find(wanted.begin(), wanted.end(), item.id) != wanted.end();
    if ((!class_name || other_class) && !is_wanted) continue;
    Product product = {item, file, class_name.value_or(""), {}, 0, item.fault};
    product.model.id = LibraryId(item.id);
    product.model.name = item.name;
    product.model.class_name = product.class_name;
    product.model.creator = item.creator;
    product.model.licence = catalogue.licence;
    products.push_back(std::move(product));
  }
  return products;
}

}  // namespace

Result<Products> ReadProducts(const fs::path& catalogues,
                              const std::vector<std::string>& wanted,
                              Progress& progress,
                              const std::vector<std::string>& classes) {
  const Result<std::vector<fs::path>> files = CatalogueFiles(catalogues);
  if (!files) return files.error();
  Products all;
  for (std::size_t n = 0; n < files->size(); ++n) {
    if (progress.StopRequested()) return Interrupted();
    progress.Report(n, files->size());
    const Result<OpenCatalogue> open = ReadCatalogue((*files)[n]);
    if (!open) return open.error();
    all.num_catalogue_items += static_cast<int>(open->catalogue.items.size());
    std::vector<Product> found =
        ProductsOf(open->catalogue, (*files)[n].filename().string(), wanted, classes);
    if (const Status status = FillModels(open->archive, found, progress); !status) {
      return status.error();
    }
    // 1 MiB of text; one that claims more is left out.
    constexpr std::size_t kMaxLicenceBytes = 1U << 20U;
    const Result<std::string> licence = open->archive.Read("LICENSE.TXT", kMaxLicenceBytes);
    all.licences[open->catalogue.name] =
        open->catalogue.licence + "\n" + (licence ? *licence : std::string());
    std::move(found.begin(), found.end(), std::back_inserter(all.products));
  }
  progress.Report(files->size(), files->size());
  return all;
}

}  // namespace deepslam::library
