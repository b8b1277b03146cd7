add_executable(deepslam
  batch_capture.cc batch_command.cc batch_display.cc batch_local.cc batch_slurm.cc batch_summary.cc batch_worker.cc
  command_tree.cc completion_script.cc config_command.cc console.cc convert_command.cc deepslam.cc doctor_command.cc eval_silhouettes.cc expand_command.cc forms_command.cc inspect_command.cc
  make_command.cc man_page.cc
  run_capture.cc run_command.cc
  furniture_files.cc known_shapes.cc priors_command.cc priors_look.cc synth_capture.cc training_models.cc training_shards.cc)
target_link_libraries(deepslam PRIVATE deepslam::batch deepslam::stages deepslam::convert deepslam::layouts deepslam::synth deepslam::furniture deepslam::priors CLI11::CLI11 spdlog::spdlog fmt::fmt)
deepslam_compile_options(deepslam)
target_sources(deepslam PRIVATE
  candidate_files.cc eval_data.cc eval_detections.cc eval_held_out.cc eval_layout.cc eval_map.cc eval_objects.cc eval_selection.cc eval_trajectory.cc)
set_target_properties(deepslam PROPERTIES INSTALL_RPATH "$ORIGIN/../${DEEPSLAM_PRIVATE_LIBDIR}")
install(TARGETS deepslam)
