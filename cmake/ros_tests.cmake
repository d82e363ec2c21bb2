# Tests of the layers that know ROS: test/ros/test_X.cpp is a plain gtest, unless test/ros/X.test is beside it, which then starts
# it with a roscore of its own.
function(link_ros_test target)
  target_link_libraries(${target} warnings ${PROJECT_NAME}_ros $<TARGET_NAME_IF_EXISTS:${PROJECT_NAME}_baselines>
    ${PROJECT_NAME}_sim ${catkin_LIBRARIES} ${ARGN})
  target_compile_definitions(${target} PRIVATE PPC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  add_dependencies(${target} ${${PROJECT_NAME}_EXPORTED_TARGETS})
endfunction()

file(GLOB ros_test_sources CONFIGURE_DEPENDS test/ros/test_*.cpp)
foreach(source IN LISTS ros_test_sources)
  get_filename_component(name ${source} NAME_WE)
  string(REGEX REPLACE "^test_" "" name ${name})
  if(EXISTS ${PROJECT_SOURCE_DIR}/test/ros/${name}.test)
    add_rostest_gtest(ros_${name} test/ros/${name}.test ${source})
    link_ros_test(ros_${name} GTest::gtest)
    if(TARGET ${PROJECT_NAME}_nodelets)
      add_dependencies(ros_${name} ${PROJECT_NAME}_nodelets)
    endif()
  else()
    catkin_add_gtest(ros_${name} ${source})
    link_ros_test(ros_${name} GTest::gtest_main)
  endif()
endforeach()

# test/ros/test_X.py is a rostest written in Python; X.test starts it.
file(GLOB ros_test_scripts CONFIGURE_DEPENDS test/ros/test_*.py)
foreach(script IN LISTS ros_test_scripts)
  get_filename_component(name ${script} NAME_WE)
  string(REGEX REPLACE "^test_" "" name ${name})
  add_rostest(test/ros/${name}.test DEPENDENCIES ppc ${PROJECT_NAME}_nodelets)
endforeach()
