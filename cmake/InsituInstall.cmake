# Installed package: find_package(insitu), pkg-config insitu.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/insitu)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/insituConfig.cmake.in
  ${PROJECT_BINARY_DIR}/insituConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/insituConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/insituConfig.cmake ${PROJECT_BINARY_DIR}/insituConfigVersion.cmake
        DESTINATION ${package_dir})
install(EXPORT insituTargets NAMESPACE insitu:: DESTINATION ${package_dir})

configure_file(${PROJECT_SOURCE_DIR}/cmake/insitu.pc.in ${PROJECT_BINARY_DIR}/insitu.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/insitu.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
