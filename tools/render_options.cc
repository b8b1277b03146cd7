#include "render_options.h"
#include "number_from.h"

#include <CLI/CLI.hpp>

namespace deepslam::tools {

void AddClassOption(CLI::App& command, std::vector<std::string>& classes) {
  command.add_option("--class", classes, "Class of the map; may be given again")
      ->check(CLI::IsMember({"chair", "table", "sofa", "bed", "cabinet", "shelf"}))
      ->capture_default_str();
}

void AddModelOptions(CLI::App& command, TrainingModelRequest& models) {
  command.add_option("--designs", models.num_designs, "Generated designs of each class")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  command.add_option("--first-design", models.first_design, "Number of the first of them")
      ->check(CLI::Range(0, 100'000'000))
      ->capture_default_str();
  command
      .add_option("--variants",
                  models.num_variants,
                  "Variants of products and meshes: other proportions, other backs")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command
      .add_option("--widened",
                  models.num_widened,
                  "Sofas made of each armchair, which becomes as wide: other sofas to learn from")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command
      .add_option(
          "--narrowed",
          models.num_narrowed,
          "Armchairs made of each sofa, which becomes as narrow: other chairs to learn from")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  command.add_flag(
      "--withheld",
      models.withheld,
      "The withheld products instead, and nothing else: for tests, never for training");
}

void AddViewOptions(CLI::App& command, RenderRequest& render) {
  command.add_option("--views", render.views, "Views of each generated design")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command.add_option("--product-views", render.product_views, "Views of each product and mesh")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command.add_flag("--clean", render.clean, "Whole objects, without faults of sensor and mask");
  command
      .add_option(
          "--tops",
          render.tops,
          "Share of the views of which only what lies above some height is left, cut by the "
          "image: tables seen from close by")
      ->check(NumberFrom(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--seed", render.seed, "Of designs and views")->capture_default_str();
}

}  // namespace deepslam::tools
