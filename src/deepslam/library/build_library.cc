#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/library/alike.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/library/library_files.h"
#include "deepslam/library/products.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::library {
namespace {

bool IsWithheld(const Product& product, const std::vector<std::string>& withheld) {
  return std::find(withheld.begin(), withheld.end(), product.item.id) != withheld.end();
}

bool SameProduct(const Product& a, const Product& b) {
  constexpr double kSameShapeIou = 0.95;   // IoU: one product in two catalogues, or in two colours
  constexpr double kSameSizeShare = 0.05;  // of each side; catalogues round to centimetres
  const Eigen::Array3d ratio = a.model.size_m.array() / b.model.size_m.array();
  return a.class_name == b.class_name && (ratio - 1.0).abs().maxCoeff() < kSameSizeShare &&
         shape::GridIntersectionOverUnion(a.model.shape, b.model.shape) > kSameShapeIou;
}

void DropLikeWithheld(const std::vector<std::string>& withheld, std::vector<Product>& products) {
  std::vector<const Product*> hidden;
  for (const Product& product : products) {
    if (product.dropped.empty() && IsWithheld(product, withheld)) hidden.push_back(&product);
  }
  std::vector<std::optional<ComparableShape>> hidden_shapes(hidden.size());
  ParallelFor(hidden.size(),
              [&](std::size_t n) { hidden_shapes[n].emplace(hidden[n]->model.shape); });
  ParallelFor(products.size(), [&](std::size_t n) {
    Product& product = products[n];
    if (hidden.empty() || !product.dropped.empty() || IsWithheld(product, withheld)) return;
    const ComparableShape shape(product.model.shape);
    for (std::size_t h = 0; h < hidden.size(); ++h) {
      if (!Alike(*hidden_shapes[h], shape)) continue;
      product.dropped = "shape like the withheld " + hidden[h]->item.id;
      return;
    }
  });
}

// Marks what must not enter: withheld products, shapes like theirs, ids and shapes that are there
// already.
void DropUnwanted(const std::vector<std::string>& withheld, std::vector<Product>& products) {
  DropLikeWithheld(withheld, products);
  std::vector<const Product*> kept;
  std::set<std::string> ids;
  for (Product& product : products) {
    if (IsWithheld(product, withheld)) product.dropped = "withheld";
    if (!product.dropped.empty()) continue;
    for (const Product* other : kept) {
      if (!product.dropped.empty()) break;
      if (SameProduct(*other, product))
        product.dropped = "same shape and size as " + other->item.id;
    }
    if (product.dropped.empty() && !ids.insert(product.model.id).second)
      product.dropped = "id not unique";
    if (product.dropped.empty()) kept.push_back(&product);
  }
}

Status CheckWithheldFound(const std::vector<Product>& products,
                          const std::vector<std::string>& withheld) {
  for (const std::string& id : withheld) {
    const auto it = std::find_if(products.begin(), products.end(), [&](const Product& product) {
      return product.item.id == id;
    });
    if (it == products.end()) {
      return InvalidConfig("withheld model '" + id + "' is in none of the catalogues");
    }
    if (!it->dropped.empty()) {
      return InvalidConfig("withheld model '" + id + "' cannot be read: " + it->dropped);
    }
  }
  return Ok();
}

}  // namespace

Result<LibrarySummary> BuildLibrary(const BuildLibraryOptions& options, Progress& progress) {
  Result<Products> read = ReadProducts(options.catalogues, options.withheld, progress);
  if (!read) return read.error();
  std::vector<Product>& products = read->products;
  if (const Status status = CheckWithheldFound(products, options.withheld); !status) {
    return status.error();
  }
  DropUnwanted(options.withheld, products);
  LibrarySummary summary;
  summary.num_catalogue_items = read->num_catalogue_items;
  ModelLibrary library;
  for (Product& product : products) {
    if (!product.dropped.empty()) {
      summary.dropped.push_back(product.item.id + ": " + product.dropped);
      continue;
    }
    ++summary.per_class[product.class_name];
    library.models.push_back(std::move(product.model));
  }
  std::sort(library.models.begin(),
            library.models.end(),
            [](const LibraryModel& a, const LibraryModel& b) { return a.id < b.id; });
  if (const Status status = WriteLibrary(library, read->licences, options.out); !status) {
    return status.error();
  }
  summary.checksum = library.checksum;
  return summary;
}

Result<std::vector<CatalogueDesign>> ReadDesigns(const std::filesystem::path& catalogues,
                                                 const std::vector<std::string>& withheld,
                                                 const std::vector<std::string>& classes,
                                                 Progress& progress) {
  Result<Products> read = ReadProducts(catalogues, withheld, progress, classes);
  if (!read) return read.error();
  std::vector<Product>& products = read->products;
  if (const Status status = CheckWithheldFound(products, withheld); !status) {
    return status.error();
  }
  DropUnwanted(withheld, products);
  std::vector<CatalogueDesign> designs;
  for (Product& product : products) {
    const bool hidden = IsWithheld(product, withheld);
    if (product.class_name.empty() || (!hidden && !product.dropped.empty())) continue;
    designs.push_back({std::move(product.model),
                       std::move(product.item),
                       std::move(product.catalogue),
                       product.quarter_turns,
                       hidden});
  }
  return designs;
}

}  // namespace deepslam::library
