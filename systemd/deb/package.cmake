# Debian 12 package: run `cpack` in the build folder. dpkg-shlibdeps determines the library dependencies.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ovws)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_CONTACT "The ovws maintainers <maintainers@ovws.invalid>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, udev, procps")  # procps provides kill for ExecReload in the units
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-zmq, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "gnuplot-nox, python3-h5py, python3-astropy, python3-tango, aravis-tools-cli")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/conffiles ${CMAKE_CURRENT_LIST_DIR}/postinst
    ${CMAKE_CURRENT_LIST_DIR}/prerm ${CMAKE_CURRENT_LIST_DIR}/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_STRIP_FILES ON)
# The configuration is in /etc, independent of the prefix.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
include(CPack)
