# The layers above the core, in the order of the arrows. `if(TARGET ...)` is not needed once every folder has sources.
add_layer(baselines)
if(TARGET ${PROJECT_NAME}_baselines)
  target_include_directories(${PROJECT_NAME}_baselines SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
  target_link_libraries(${PROJECT_NAME}_baselines PUBLIC ${PROJECT_NAME}_core PRIVATE ${PCL_LIBRARIES})
endif()

add_layer(sim)
if(TARGET ${PROJECT_NAME}_sim)
  target_link_libraries(${PROJECT_NAME}_sim PUBLIC ${PROJECT_NAME}_core)
endif()

add_layer(evaluation)
if(TARGET ${PROJECT_NAME}_evaluation)
  target_link_libraries(${PROJECT_NAME}_evaluation PUBLIC ${PROJECT_NAME}_core)
endif()

add_layer(ros)
if(TARGET ${PROJECT_NAME}_ros)
  target_link_libraries(${PROJECT_NAME}_ros PUBLIC ${PROJECT_NAME}_core ${PROJECT_NAME}_sim ${catkin_LIBRARIES} yaml-cpp
    PRIVATE OpenGL::GLU)
  add_dependencies(${PROJECT_NAME}_ros ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endif()

add_layer(nodelets)
if(TARGET ${PROJECT_NAME}_nodelets)
  target_link_libraries(${PROJECT_NAME}_nodelets PRIVATE ${PROJECT_NAME}_ros $<TARGET_NAME_IF_EXISTS:${PROJECT_NAME}_baselines>)
  add_dependencies(${PROJECT_NAME}_nodelets ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endif()

file(GLOB ppc_tool_sources CONFIGURE_DEPENDS src/tools/ppc/*.cpp)
if(ppc_tool_sources)
  add_executable(ppc ${ppc_tool_sources})
  target_include_directories(ppc PRIVATE src/tools/ppc)
  target_include_directories(ppc SYSTEM PRIVATE ${PCL_INCLUDE_DIRS} ${OpenCV_INCLUDE_DIRS})
  foreach(layer ros baselines sim evaluation)
    target_link_libraries(ppc PRIVATE $<TARGET_NAME_IF_EXISTS:${PROJECT_NAME}_${layer}>)
  endforeach()
  target_link_libraries(ppc PRIVATE warnings yaml-cpp ${PCL_LIBRARIES} ${OpenCV_LIBS} CLI11::CLI11
    nlohmann_json::nlohmann_json)
  target_link_options(ppc PRIVATE -Wl,--as-needed)  # PCL's list of libraries includes VTK and Qt
  install(TARGETS ppc RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()
