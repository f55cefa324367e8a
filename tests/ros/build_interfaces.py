"""Makes Python packages of interface definitions, with the generators of rosidl that the wheels of ROS 2 contain.

What ROS's build system spreads over many libraries per package is one extension module here: C structures, conversion from and
to Python, and the type support in C for Fast DDS (which wants introspection too). Nothing is made for C++. Runs under the
Python of the environment that the packages are made for.
Usage: build_interfaces.py <folder of interfaces> <folder to build in>
"""

import contextlib
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl
from rosidl_generator_c import generate_c
from rosidl_generator_py import generate_py
from rosidl_generator_type_description import generate_type_hash
from rosidl_typesupport_c import generate_c as generate_typesupport_c
from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c
from rosidl_typesupport_introspection_c import generate_c as generate_introspection_c

PREFIX = pathlib.Path(sys.prefix)
SITE_PACKAGES = pathlib.Path(sysconfig.get_path("platlib"))
COMPILE_TIMEOUT_S = 300
TYPE_SUPPORTS = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]


def generate(source, build):
    """Generates the sources of the package whose definitions are in the folder source into build/<generator>/<package>."""
    package = source.name
    definitions = sorted([*source.glob("msg/*.msg"), *source.glob("srv/*.srv")])
    interfaces = [definition.relative_to(source) for definition in definitions]
    idl_folder = build / "idl" / package
    for interface in interfaces:
        convert = convert_msg_to_idl if interface.suffix == ".msg" else convert_srv_to_idl
        with contextlib.redirect_stdout(io.StringIO()):
            convert(source, package, interface, idl_folder / interface.parent)

    idl_paths = [interface.with_suffix(".idl") for interface in interfaces]
    arguments = {
        "package_name": package,
        "idl_tuples": [f"{idl_folder}:{path}" for path in idl_paths],
        "include_paths": [f"{share.name}:{share}" for share in (PREFIX / "share").iterdir()],
        "ros_interface_dependencies": [],
        "ros_interface_files": [str(definition) for definition in definitions],
        "target_dependencies": [],
    }

    def run(generate_sources, generator, *options):
        output = build / generator / package
        templates = PREFIX / "share" / generator / "resource"
        arguments.update(output_dir=str(output), template_dir=str(templates))
        arguments_path = idl_folder / "arguments.json"
        arguments_path.write_text(json.dumps(arguments))
        generate_sources(str(arguments_path), *options)
        for template in templates.glob("*visibility_control.h.in"):
            text = template.read_text().replace("@PROJECT_NAME@", package).replace("@PROJECT_NAME_UPPER@", package.upper())
            (output / "msg").mkdir(exist_ok=True)
            (output / "msg" / template.stem).write_text(text)

    run(generate_type_hash, "rosidl_generator_type_description")
    hashes = build / "rosidl_generator_type_description" / package
    arguments["type_description_tuples"] = [f"{path}:{hashes / path.with_suffix('.json')}" for path in idl_paths]
    run(generate_c, "rosidl_generator_c")
    run(generate_typesupport_fastrtps_c, "rosidl_typesupport_fastrtps_c")
    run(generate_introspection_c, "rosidl_typesupport_introspection_c")
    run(generate_typesupport_c, "rosidl_typesupport_c", TYPE_SUPPORTS)
    run(generate_py, "rosidl_generator_py", ["rosidl_typesupport_c"])


def run_compiler(arguments):
    result = subprocess.run(arguments, capture_output=True, text=True, timeout=COMPILE_TIMEOUT_S)
    if result.returncode != 0:
        sys.exit(f"{' '.join(arguments)}\n{result.stderr}")


def compile_source(source, build):
    language = ["gcc", "-std=c11"] if source.suffix == ".c" else ["g++", "-std=c++17"]
    headers = PREFIX / "include"
    includes = [*build.iterdir(), sysconfig.get_path("include"), numpy.get_include(), headers, *headers.iterdir()]
    run_compiler([*language, "-O0", "-fPIC", "-w", *(f"-I{path}" for path in includes), "-c", str(source), "-o", f"{source}.o"])


def link(package, build):
    """Links all objects of a package into the extension module that rclpy looks for."""
    objects = [str(path) for path in build.glob(f"*/{package}/**/*.o")]
    libraries = [str(path) for path in (PREFIX / "lib").glob("lib*.so") if not path.is_symlink() and "_cpp.so" not in path.name]
    module = build / "rosidl_generator_py" / package / extension_name(package)
    options = ["-Wl,--as-needed", f"-Wl,-rpath-link,{PREFIX / 'lib'}", "-Wl,-rpath,$ORIGIN/../../.."]
    run_compiler(["g++", "-shared", *objects, "-o", str(module), *options, *libraries])


def extension_name(package):
    return f"{package}_s__rosidl_typesupport_c.so"


def install(package, build):
    """Puts modules and extension where Python finds them, and the extension where the dispatcher looks for type support."""
    installed = SITE_PACKAGES / package
    shutil.rmtree(installed, ignore_errors=True)
    shutil.copytree(build / "rosidl_generator_py" / package, installed, ignore=shutil.ignore_patterns("*.c", "*.o"))
    (installed / "__init__.py").touch()
    for type_support in TYPE_SUPPORTS:
        library = PREFIX / "lib" / f"lib{package}__{type_support}.so"
        library.unlink(missing_ok=True)
        library.symlink_to(installed / extension_name(package))


def main():
    interfaces, build = (pathlib.Path(argument).absolute() for argument in sys.argv[1:])
    sources = sorted(interfaces.iterdir())
    packages = [source.name for source in sources]
    shutil.rmtree(build, ignore_errors=True)
    build.mkdir(parents=True)
    workers = os.cpu_count()
    with ProcessPoolExecutor(workers) as pool:
        list(pool.map(generate, sources, [build] * len(sources)))
    with ThreadPoolExecutor(workers) as pool:
        to_compile = [path for path in build.rglob("*") if path.suffix in (".c", ".cpp")]
        list(pool.map(compile_source, to_compile, [build] * len(to_compile)))
    for package in packages:
        link(package, build)
        install(package, build)


if __name__ == "__main__":
    main()
