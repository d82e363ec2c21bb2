# benchmark/: the floor kernels, which the tests check, and where Google Benchmark is installed the program that scripts/benchmark
# builds and runs. Neither is part of the default build.
add_library(benchmark_floor STATIC EXCLUDE_FROM_ALL benchmark/floor_sums.cpp benchmark/floor_fits.cpp)
target_include_directories(benchmark_floor PUBLIC benchmark)
target_link_libraries(benchmark_floor PRIVATE warnings)

find_package(benchmark QUIET)
if(benchmark_FOUND AND TARGET ${PROJECT_NAME}_ros AND TARGET ${PROJECT_NAME}_baselines)
  file(GLOB benchmark_sources CONFIGURE_DEPENDS benchmark/*.cpp)
  list(FILTER benchmark_sources EXCLUDE REGEX "/floor_(sums|fits)\\.cpp$")
  #catkin_lint: ignore_once uninstalled_target
  add_executable(ppc_benchmark EXCLUDE_FROM_ALL ${benchmark_sources})
  target_link_libraries(ppc_benchmark PRIVATE warnings benchmark_floor ${PROJECT_NAME}_ros ${PROJECT_NAME}_baselines
    ${PROJECT_NAME}_sim benchmark::benchmark)
  add_dependencies(ppc_benchmark ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endif()
