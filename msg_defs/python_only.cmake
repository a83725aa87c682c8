# If PYTHON_ONLY is set, nothing is generated for C++: the build takes half of the time.
# Include this after all packages are found.
option(PYTHON_ONLY "Generate interfaces for Python alone" OFF)
if(PYTHON_ONLY)
  list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")
endif()
