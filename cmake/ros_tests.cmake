# Tests of running nodelets: test/ros/<name>.test starts them and test/ros/test_<name>.cpp, a gtest node called ros_<name>.
file(GLOB ros_test_launches CONFIGURE_DEPENDS test/ros/*.test)
foreach(launch IN LISTS ros_test_launches)
  get_filename_component(name ${launch} NAME_WE)
  add_rostest_gtest(ros_${name} ${launch} test/ros/test_${name}.cpp)
  target_link_libraries(ros_${name} warnings ${PROJECT_NAME}_ros ${catkin_LIBRARIES})
  target_compile_definitions(ros_${name} PRIVATE PPC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  add_dependencies(ros_${name} ${PROJECT_NAME}_nodelets)
endforeach()
