"""Where voices come from, who of them speaks, and what each of them says by itself."""
