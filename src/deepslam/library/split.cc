#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/core/sha256.h"
#include "deepslam/library/alike.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/library/products.h"

namespace deepslam::library {
namespace {

// For every product the first one that a chain of alike shapes leads to.
std::vector<std::size_t> GroupByShape(const std::vector<Product>& products) {
  std::vector<std::optional<ComparableShape>> shapes(products.size());
  ParallelFor(products.size(),
              [&](std::size_t n) { shapes[n].emplace(products[n].model.shape); });
  std::vector<std::vector<std::size_t>> alike(products.size());
  ParallelFor(products.size(), [&](std::size_t a) {
    for (std::size_t b = a + 1; b < products.size(); ++b) {
      if (products[a].item.id == products[b].item.id || Alike(*shapes[a], *shapes[b]))
        alike[a].push_back(b);
    }
  });
  std::vector<std::size_t> group(products.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (std::size_t a = 0; a < products.size(); ++a) {
    for (const std::size_t b : alike[a]) {
      const std::size_t low = std::min(group[a], group[b]);
      const std::size_t high = std::max(group[a], group[b]);
      for (std::size_t& g : group) g = g == high ? low : g;
    }
  }
  return group;
}

struct Group {
  std::string order;
  std::vector<std::size_t> members;  // first = the one by whose name the group goes
};

std::vector<Group> ShuffledGroups(const std::vector<Product>& products) {
  const std::vector<std::size_t> group_of = GroupByShape(products);
  std::map<std::size_t, Group> groups;
  for (std::size_t n = 0; n < products.size(); ++n) groups[group_of[n]].members.push_back(n);
  std::vector<Group> shuffled;
  for (auto& [first, group] : groups) {
    group.order = Sha256Hex(products[first].item.id);
    shuffled.push_back(std::move(group));
  }
  std::sort(shuffled.begin(), shuffled.end(), [](const Group& a, const Group& b) {
    return a.order < b.order;
  });
  return shuffled;
}

}  // namespace

Result<std::vector<WithheldProduct>> ChooseWithheld(const std::filesystem::path& catalogues,
                                                    double share,
                                                    Progress& progress) {
  Result<Products> read = ReadProducts(catalogues, {}, progress);
  if (!read) return read.error();
  std::vector<Product>& products = read->products;
  std::erase_if(products, [](const Product& product) { return !product.dropped.empty(); });
  std::stable_sort(products.begin(), products.end(), [](const Product& a, const Product& b) {
    return a.item.id < b.item.id;
  });
  std::map<std::string, int> room;  // that is left for withheld products of a class
  for (const Product& product : products) ++room[product.class_name];
  for (auto& [class_name, count] : room)
    count = static_cast<int>(std::lround(share * static_cast<double>(count)));
  std::vector<WithheldProduct> withheld;
  for (const Group& group : ShuffledGroups(products)) {
    std::map<std::string, int> needed;
    for (const std::size_t n : group.members) ++needed[products[n].class_name];
    const bool fits = std::all_of(needed.begin(), needed.end(), [&](const auto& entry) {
      return entry.second <= room[entry.first];
    });
    if (!fits) continue;
    for (const std::size_t n : group.members) {
      const Product& product = products[n];
      --room[product.class_name];
      withheld.push_back({product.item.id,
                          product.item.name,
                          product.class_name,
                          product.catalogue,
                          product.item.model});
    }
  }
  std::sort(withheld.begin(), withheld.end(), [](const auto& a, const auto& b) {
    return std::pair(a.class_name, a.id) < std::pair(b.class_name, b.id);
  });
  return withheld;
}

std::string WithheldYaml(const std::vector<WithheldProduct>& withheld) {
  std::string text =
      "# Products that neither the retrieval library nor training may hold, neither by catalogue id "
      "nor by shape:\n"
      "# what is found of them in rendered captures is really found, not looked up. Made by\n"
      "#   deepslam library split\n"
      "# Ids as in the Sweet Home 3D catalogues, always in double quotes; mesh is the OBJ inside "
      "the catalogue.\n"
      "withheld:\n";
  std::string class_name;
  for (const WithheldProduct& product : withheld) {
    if (product.class_name != class_name) text += "  # " + product.class_name + "\n";
    class_name = product.class_name;
    text += "  - id: \"" + product.id + "\"\n    catalogue: " + product.catalogue +
            "\n    mesh: " + product.mesh + "\n";
  }
  return text;
}

}  // namespace deepslam::library
