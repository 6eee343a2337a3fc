// placeholder so that the library has a source until its own arrive
