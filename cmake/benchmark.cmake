# benchmark/: the floor kernels, which the tests check, and where Google Benchmark is installed the program that scripts/benchmark
# builds and runs; and the program whose instructions a test counts. None is part of the default build.
add_library(benchmark_floor STATIC EXCLUDE_FROM_ALL benchmark/floor_sums.cpp benchmark/floor_fits.cpp)
target_include_directories(benchmark_floor PUBLIC benchmark)
target_link_libraries(benchmark_floor PRIVATE warnings)

#catkin_lint: ignore_once uninstalled_target
add_executable(ppc_count EXCLUDE_FROM_ALL benchmark/count_main.cpp benchmark/workload.cpp)
target_link_libraries(ppc_count PRIVATE warnings benchmark_floor ${PROJECT_NAME}_sim)
add_dependencies(tests ppc_count)
# Its bounds are those of optimised code, and valgrind cannot run what a sanitizer is built into.
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT CMAKE_CXX_FLAGS MATCHES "sanitize")
  add_test(NAME benchmark_instructions
    COMMAND ${PYTHON_EXECUTABLE} ${PROJECT_SOURCE_DIR}/test/benchmark/test_instructions.py $<TARGET_FILE:ppc_count>)
endif()

find_package(benchmark QUIET)
if(benchmark_FOUND AND TARGET ${PROJECT_NAME}_ros AND TARGET ${PROJECT_NAME}_baselines)
  file(GLOB benchmark_sources CONFIGURE_DEPENDS benchmark/*.cpp)
  list(FILTER benchmark_sources EXCLUDE REGEX "/(floor_(sums|fits)|count_main)\\.cpp$")
  #catkin_lint: ignore_once uninstalled_target
  add_executable(ppc_benchmark EXCLUDE_FROM_ALL ${benchmark_sources})
  target_link_libraries(ppc_benchmark PRIVATE warnings benchmark_floor ${PROJECT_NAME}_ros ${PROJECT_NAME}_baselines
    ${PROJECT_NAME}_sim benchmark::benchmark)
  add_dependencies(ppc_benchmark ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endif()
