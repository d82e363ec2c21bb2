# Fuzz targets: fuzz/fuzz_X.cpp with its seeds in fuzz/corpus/X. With PPC_FUZZ (clang; scripts/fuzz sets the flags) fuzz_X is a
# libFuzzer program; the test fuzz_X_replay needs no clang and runs the corpus and some mutations of it.
file(GLOB fuzz_sources CONFIGURE_DEPENDS fuzz/fuzz_*.cpp)
if(CATKIN_ENABLE_TESTING OR PPC_FUZZ)
  add_library(fuzz_support STATIC EXCLUDE_FROM_ALL fuzz/checks.cpp fuzz/scene.cpp src/tools/ppc/cloud_file.cpp
    src/tools/ppc/pcd_header.cpp
    src/tools/ppc/files.cpp src/tools/ppc/interruption.cpp src/tools/ppc/method_options.cpp)
  target_include_directories(fuzz_support PUBLIC src/tools/ppc)
  target_include_directories(fuzz_support SYSTEM PRIVATE ${PCL_INCLUDE_DIRS} ${OpenCV_INCLUDE_DIRS})
  target_link_libraries(fuzz_support PRIVATE warnings PUBLIC ${PROJECT_NAME}_ros ${PROJECT_NAME}_baselines
    ${PROJECT_NAME}_evaluation pcl_io pcl_common opencv_core opencv_imgcodecs yaml-cpp CLI11::CLI11)
  add_dependencies(fuzz_support ${${PROJECT_NAME}_EXPORTED_TARGETS})
endif()
foreach(source IN LISTS fuzz_sources)
  get_filename_component(name ${source} NAME_WE)
  string(REGEX REPLACE "^fuzz_" "" topic ${name})
  if(PPC_FUZZ)
    add_executable(${name} ${source} fuzz/libfuzzer_main.cpp)
    target_link_libraries(${name} warnings fuzz_support)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer -Wl,--as-needed)
  elseif(CATKIN_ENABLE_TESTING)
    catkin_add_gtest(${name}_replay ${source} fuzz/replay.cpp)
    target_link_libraries(${name}_replay warnings fuzz_support GTest::gtest_main)
    target_link_options(${name}_replay PRIVATE -Wl,--as-needed)
    target_compile_definitions(${name}_replay PRIVATE PPC_FUZZ_CORPUS="${PROJECT_SOURCE_DIR}/fuzz/corpus/${topic}")
  endif()
endforeach()
