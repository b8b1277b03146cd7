# Two programs. `deepslam` is what maps captures. What makes worlds, training data and figures (synth, eval, priors), and what
# needs all commands there are (completions, man page), is `deepslam-tools`; `deepslam` starts it where it is asked for such.
add_library(deepslam_commands OBJECT
  batch_capture.cc batch_command.cc batch_display.cc batch_local.cc batch_slurm.cc batch_summary.cc batch_worker.cc
  command_line.cc config_command.cc console.cc convert_command.cc doctor_command.cc expand_command.cc
  library_command.cc number_from.cc run_capture.cc run_command.cc validate_command.cc)
target_link_libraries(deepslam_commands PUBLIC
  deepslam::batch deepslam::stages deepslam::convert deepslam::layouts CLI11::CLI11 spdlog::spdlog fmt::fmt)
deepslam_compile_options(deepslam_commands)
target_link_libraries(deepslam_commands PUBLIC deepslam_optimized_less)
deepslam_compile_headers(deepslam_command_headers HEADERS <CLI/CLI.hpp> LINKS CLI11::CLI11 deepslam_optimized_less)
deepslam_use_headers(deepslam_commands deepslam_command_headers)

add_executable(deepslam deepslam.cc other_program.cc)
target_link_libraries(deepslam PRIVATE deepslam_commands)

add_executable(deepslam_tools
  candidate_files.cc catalogue_products.cc command_tree.cc completion_script.cc deepslam_tools.cc eval_boxes.cc eval_command.cc eval_data.cc
  eval_detections.cc eval_held_out.cc eval_layout.cc eval_map.cc eval_objects.cc eval_selection.cc
  eval_silhouettes.cc eval_surfaces.cc eval_trajectory.cc eval_unseen.cc forms_command.cc furniture_files.cc known_shapes.cc man_page.cc
  packed_products.cc priors_command.cc priors_look.cc render_options.cc render_shards.cc synth_capture.cc synth_command.cc training_models.cc training_shards.cc)
target_link_libraries(deepslam_tools PRIVATE
  deepslam_commands deepslam::eval deepslam::synth deepslam::furniture deepslam::priors)
set_target_properties(deepslam_tools PROPERTIES OUTPUT_NAME deepslam-tools)
add_dependencies(deepslam deepslam_tools)  # what it starts lies beside it

foreach(program deepslam deepslam_tools)
  deepslam_compile_options(${program})
  deepslam_use_headers(${program} deepslam_command_headers)
  set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/../${DEEPSLAM_PRIVATE_LIBDIR}")
  install(TARGETS ${program})
endforeach()
# What renders training views of packed products: carried to another machine with the few libraries it loads.
add_executable(deepslam_views
  known_shapes.cc number_from.cc packed_products.cc render_options.cc render_shards.cc training_models.cc training_shards.cc views_program.cc)
target_link_libraries(deepslam_views PRIVATE
  deepslam::priors deepslam::furniture deepslam::library deepslam::storage deepslam::artifact CLI11::CLI11 fmt::fmt)
target_link_options(deepslam_views PRIVATE -Wl,--as-needed -Wl,--gc-sections)
set_target_properties(deepslam_views PROPERTIES OUTPUT_NAME deepslam-views)
deepslam_compile_options(deepslam_views)
deepslam_use_headers(deepslam_views deepslam_command_headers)
# The command line's own templates take most of a command's time to compile: several commands share them.
set_target_properties(deepslam_commands deepslam_tools PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
